//! Tells the program its version: with the commit in a release build, so that a result can be traced to the code.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    // While one works on it, every commit would compile everything anew.
    let release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = if release { commit() } else { None };
    let version = commit.map_or(version.clone(), |commit| format!("{version} ({commit})"));
    println!("cargo:rustc-env=OCCLUSCOPE_VERSION={version}");
}

/// The commit that is checked out, marked where files differ from it; `None` where there is no repository.
fn commit() -> Option<String> {
    let root = git(&["rev-parse", "--show-toplevel"])?;
    // A source archive inside of somebody else's repository has no commit of its own.
    let here = std::env::current_dir().ok()?.canonicalize().ok()?;
    if std::path::Path::new(&root).canonicalize().ok()? != here {
        return None;
    }
    // A commit and a checkout add a line to the log; a change of a file makes the mark.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]);
    for path in log.iter().map(String::as_str).chain(["src", "Cargo.toml", "Cargo.lock"]) {
        // What is not there would count as changed every time.
        if std::path::Path::new(path).exists() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    git(&["describe", "--always", "--dirty", "--exclude=*"])
}

/// What git says, in a line.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned()).filter(|text| !text.is_empty())
}
