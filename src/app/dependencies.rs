//! The directions in which the modules of the window may depend on each other.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Each folder, with the modules of the window that it may use besides itself.
const ALLOWED: [(&str, &[&str]); 6] = [
    ("model", &[]),
    ("commands", &["model", "icons"]),
    ("files", &["model"]),
    // Plots and tables write themselves with `files::atomic_write`.
    ("inspector", &["model", "commands", "files", "icons", "theme"]),
    ("panels", &["model", "commands", "icons", "menu_item", "theme"]),
    ("views", &["model", "commands", "icons", "menu_item", "theme"]),
];

/// The module of the window that follows each `crate::app::` in a source text, outside comments and test code.
fn used_modules(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let uses = lines.flat_map(|line| line.split("crate::app::").skip(1));
    uses.map(|rest| {
        rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next().unwrap_or("")
    })
    .map(str::to_owned)
    .collect()
}

/// The source files of a folder and its subfolders, without test files.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.file_stem().is_some_and(|stem| stem == "tests");
        if path.is_dir() && !is_test {
            found.extend(sources(&path));
        } else if !is_test && path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

#[test]
fn modules_are_found_in_code_but_not_in_comments_or_tests() {
    let source = "//! See [`crate::app::views`].\nuse crate::app::model::Model;\n\
                  fn f() { crate::app::panels::g(); }\n#[cfg(test)]\nmod tests { use crate::app::files::h; }\n";
    assert_eq!(used_modules(source), ["model", "panels"]);
}

#[test]
fn folders_use_only_the_modules_below_them() {
    let app = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/app");
    let mut wrong = Vec::new();
    for (folder, allowed) in ALLOWED {
        let files = sources(&app.join(folder));
        assert!(!files.is_empty(), "{folder}");
        for file in files {
            for module in used_modules(&fs::read_to_string(&file).unwrap()) {
                if module != folder && !allowed.contains(&module.as_str()) {
                    wrong.push(format!("{} uses {module}", file.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
