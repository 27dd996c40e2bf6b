//! The command line.

fn main() -> std::process::ExitCode {
    contact_patch::cli::run()
}
