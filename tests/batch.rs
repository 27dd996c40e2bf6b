//! `contact-patch batch` as clusters use it: killed, starved, fed rubbish.
#![cfg(all(feature = "cli", unix))]

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use serde_json::Value;

fn line(k: usize) -> String {
    // Depths differ, so no line is the answer of another; the boundary makes answers longer than a page of memory.
    format!(
        "{{\"name\": \"{k}\", \"effective_modulus\": 1, \"gap\": {{\"kind\": \"cone\", \"inclination\": 45}}, \
         \"loading\": {{\"depth\": {}}}, \"output\": [\"patch\"]}}\n",
        1.0 + 1e-3 * k as f64
    )
}

#[test]
fn killed_in_mid_run_it_leaves_whole_lines() {
    let directory = tempfile::tempdir().unwrap();
    for wanted in [3_u64, 40, 400] {
        let path = directory.path().join(format!("{wanted}.ndjson"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
            .args(["batch", "--jobs", "2"])
            .stdin(Stdio::piped())
            .stdout(fs::File::create(&path).unwrap())
            .spawn()
            .unwrap();
        let mut pipe = child.stdin.take().unwrap();
        // Ends when nobody reads any more.
        let feeder =
            std::thread::spawn(move || (0..).take_while(|&k| pipe.write_all(line(k).as_bytes()).is_ok()).count());
        // Killed with SIGKILL while it writes: as soon as it has written about so many lines.
        while fs::metadata(&path).unwrap().len() < 5000 * wanted {
            assert!(child.try_wait().unwrap().is_none());
            std::thread::yield_now();
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(feeder.join().unwrap() as u64 > wanted);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.len() as u64 >= 5000 * wanted);
        // A line goes out in one call; only the kernel may cut it, between two pages of the file.
        let whole = text.rfind('\n').unwrap() + 1;
        assert!(whole == text.len() || text.len().is_multiple_of(4096), "{} of {}", whole, text.len());
        for (k, answer) in text[..whole].lines().enumerate() {
            let answer: Value = serde_json::from_str(answer).unwrap();
            assert_eq!(answer["scene"]["name"], k.to_string());
            assert_eq!(answer["verdict"], "solved");
        }
    }
}

#[test]
fn answers_come_while_lines_still_arrive() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .arg("batch")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
    for k in 0..3 {
        pipe.write_all(line(k).as_bytes()).unwrap();
        pipe.flush().unwrap();
        let answer: Value = serde_json::from_str(&answers.next().unwrap().unwrap()).unwrap();
        assert_eq!(answer["scene"]["name"], k.to_string());
    }
    drop(pipe);
    assert!(answers.next().is_none());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// Largest resident set so far, kilobytes.
#[cfg(target_os = "linux")]
fn high_water(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn memory_does_not_grow_with_the_lines() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .args(["batch", "--jobs", "2"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    let (mut text, mut after) = (String::new(), [0; 2]);
    // More lines between the two readings than the window holds, a hundred times over.
    for (lines, high) in [500, 6000].into_iter().zip(&mut after) {
        let feeder = std::thread::spawn(move || {
            (0..lines).for_each(|k| pipe.write_all(line(k).as_bytes()).unwrap());
            pipe
        });
        for _ in 0..lines {
            text.clear();
            answers.read_line(&mut text).unwrap();
        }
        pipe = feeder.join().unwrap();
        *high = high_water(child.id());
    }
    drop(pipe);
    child.wait().unwrap();
    // 6000 answers of 5 kB would be 30 MB.
    assert!(after[1] < after[0] + 6000, "{after:?} kB");
}

#[test]
fn the_line_of_the_readme_for_splitting_works() {
    // GNU split hands out whole lines; the parts, solved apart, are the whole.
    let directory = tempfile::tempdir().unwrap();
    let scenes: String = (0..20).map(line).collect();
    fs::write(directory.path().join("scenes.ndjson"), scenes).unwrap();
    let script = format!(
        "split -n l/3 -d scenes.ndjson part. && for n in 00 01 02; do {} batch < part.$n > out.$n || exit 1; done; cat out.*",
        env!("CARGO_BIN_EXE_contact-patch")
    );
    let output = Command::new("sh").args(["-c", &script]).current_dir(directory.path()).output().unwrap();
    if String::from_utf8_lossy(&output.stderr).contains("split") {
        // A system without GNU's split has nothing to test.
        return;
    }
    let text = String::from_utf8(output.stdout).unwrap();
    let names: Vec<String> =
        text.lines().map(|l| serde_json::from_str::<Value>(l).unwrap()["scene"]["name"].to_string()).collect();
    assert_eq!(names, (0..20).map(|k| format!("\"{k}\"")).collect::<Vec<_>>());
}
