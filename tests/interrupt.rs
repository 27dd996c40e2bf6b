//! A run that is ended from outside leaves no half of a file.
#![cfg(all(feature = "cli", unix))]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = r#"{"effective_modulus": 1.0, "gap": {"kind": "pyramid", "faces": 3, "inclination": 45.0},
    "loading": {"depth": 1.0}, "solve": {"method": "fft", "cells": 400}, "output": ["pressure"]}"#;

fn begin(directory: &Path) -> Child {
    fs::write(directory.join("scene.json"), SCENE).unwrap();
    Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .args(["solve", "scene.json", "--json", "r.json", "--field", "p.npy", "--threads", "1"])
        .current_dir(directory)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// The files that were asked for are whole where they are there at all.
fn nothing_half(directory: &Path, when: Duration) -> usize {
    let mut there = 0;
    if let Ok(text) = fs::read(directory.join("r.json")) {
        let result: serde_json::Value = serde_json::from_slice(&text).unwrap_or_else(|e| panic!("after {when:?}: {e}"));
        assert_eq!(result["verdict"], "solved");
        there += 1;
    }
    if let Ok(bytes) = fs::read(directory.join("p.npy")) {
        let header = 10 + usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
        let text = String::from_utf8_lossy(&bytes[10..header]).into_owned();
        let shape = text.split_once('(').and_then(|(_, rest)| rest.split_once(')')).expect("a shape").0;
        let cells: usize = shape.split(',').map(|n| n.trim().parse::<usize>().expect("a number")).product();
        assert_eq!(bytes.len(), header + 8 * cells, "after {when:?}");
        there += 1;
    }
    there
}

/// Runs once to the end, then kills at moments from the start of a run to its end.
fn ended_by(signal: &str) {
    let whole = tempfile::tempdir().unwrap();
    let clock = Instant::now();
    assert!(begin(whole.path()).wait().unwrap().success());
    let duration = clock.elapsed();
    assert_eq!(nothing_half(whole.path(), duration), 2);
    let mut ended = 0;
    for moment in 0..12 {
        let directory = tempfile::tempdir().unwrap();
        let mut child = begin(directory.path());
        let when = duration * moment / 11;
        std::thread::sleep(when);
        // The run may be over, if the machine is quicker now: then the files are there and whole.
        let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        ended += usize::from(!child.wait().unwrap().success());
        nothing_half(directory.path(), when);
    }
    // One that is ended before it has read its scene, at the least.
    assert!(ended > 0);
}

#[test]
fn a_killed_run_leaves_no_half_file() {
    ended_by("-KILL");
}

#[test]
fn an_interrupted_run_leaves_no_half_file() {
    ended_by("-INT");
}
