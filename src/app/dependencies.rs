//! The directions in which the modules of the window may depend on each other, and that no files import each other.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
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

/// What each file of the window imports from others. A file is named by its module: `views::pane`.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// A source text without comments and test code.
fn code(source: &str) -> String {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

const fn is_of_name(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_'
}

/// The module of the window that follows each `crate::app::` in a source text, outside comments and test code.
fn used_modules(source: &str) -> Vec<String> {
    let code = code(source);
    let uses = code.split("crate::app::").skip(1);
    uses.map(|rest| rest.split(|letter| !is_of_name(letter)).next().unwrap_or(""))
        .map(str::to_owned)
        .collect()
}

/// The paths at the start of a text: `a::{self, b::C};` has `a::self` and `a::b::C`.
fn paths(text: &str) -> Vec<String> {
    let end = text.find(|letter| !is_of_name(letter) && letter != ':').unwrap_or(text.len());
    let (start, rest) = text.split_at(end);
    match rest.strip_prefix('{').and_then(|rest| rest.split('}').next()) {
        Some(group) => group.split(',').map(|name| format!("{start}{}", name.trim())).collect(),
        None => vec![start.to_owned()],
    }
}

/// Whether a path that follows this text starts there, or after `self`.
fn starts_path(before: &str) -> bool {
    before.ends_with("self::") || !before.ends_with(|letter| is_of_name(letter) || letter == ':')
}

/// The paths within the window that a file names, from the window's root: after `crate::app::` and `super::`, and
/// those that start with a submodule.
fn named_paths(module: &str, code: &str, files: &BTreeSet<String>) -> Vec<String> {
    let mut found: Vec<String> = code.split("crate::app::").skip(1).flat_map(paths).collect();
    let parent = module.rsplit_once("::").map_or("", |(parent, _)| parent);
    let siblings = code.split("super::").skip(1).flat_map(paths);
    found.extend(siblings.map(|path| format!("{parent}::{path}")));
    let submodules = files.iter().filter(|file| {
        let name = file.strip_prefix(module).and_then(|rest| rest.strip_prefix("::"));
        name.is_some_and(|name| {
            code.match_indices(&format!("{name}::")).any(|(at, _)| starts_path(&code[..at]))
        })
    });
    found.extend(submodules.cloned());
    found
}

/// The file that defines a path: the longest part of it that is a file.
fn file_of<'a>(path: &'a str, files: &BTreeSet<String>) -> Option<&'a str> {
    let ends = path.match_indices("::").map(|(at, _)| at).chain([path.len()]);
    ends.map(|end| &path[..end]).filter(|part| files.contains(*part)).last()
}

/// What each file imports from others.
fn imports(codes: &BTreeMap<String, String>) -> Imports {
    let files: BTreeSet<String> = codes.keys().cloned().collect();
    let of_file = |(module, code): (&String, &String)| {
        let named = named_paths(module, code, &files);
        let used = named.iter().filter_map(|path| file_of(path, &files)).filter(|used| used != module);
        (module.clone(), used.map(str::to_owned).collect())
    };
    codes.iter().map(of_file).collect()
}

/// The files that import each other, directly or through others.
fn circles(mut imports: Imports) -> Imports {
    loop {
        let before = imports.len();
        let imported: BTreeSet<String> = imports.values().flatten().cloned().collect();
        imports.retain(|file, _| imported.contains(file));
        let files: BTreeSet<String> = imports.keys().cloned().collect();
        for used in imports.values_mut() {
            used.retain(|file| files.contains(file));
        }
        imports.retain(|_, used| !used.is_empty());
        if imports.len() == before {
            return imports;
        }
    }
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
fn circles_of_imports_are_found() {
    let codes = [
        ("views", "mod pane;\npub(crate) use pane::Pane;\nuse crate::app::model::draw::Draw;"),
        ("views::pane", "use super::{draw, layer::Layer};\nuse crate::app::theme::{self, Colours};"),
        ("views::draw", "use super::layer;\nuse super::pane::Pane;"),
        ("views::layer", "fn f() { crate::app::theme::rgb(); }"),
        ("theme", ""),
    ];
    let codes: BTreeMap<String, String> = codes.map(|(file, code)| (file.to_owned(), code.to_owned())).into();
    let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<BTreeSet<_>>();
    let imports = imports(&codes);
    assert_eq!(imports["views"], names(&["views::pane"]));
    assert_eq!(imports["views::pane"], names(&["theme", "views::draw", "views::layer"]));
    assert_eq!(imports["views::layer"], names(&["theme"]));
    let expected = [("views::draw", "views::pane"), ("views::pane", "views::draw")];
    let expected: Imports = expected.map(|(file, used)| (file.to_owned(), names(&[used]))).into();
    assert_eq!(circles(imports), expected);
}

#[test]
fn no_two_files_import_each_other() {
    let app = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/app");
    let module = |file: &Path| {
        let name = file.strip_prefix(&app).unwrap().with_extension("");
        let parts = name.iter().map(|part| part.to_str().unwrap()).filter(|part| *part != "mod");
        parts.collect::<Vec<_>>().join("::")
    };
    let read = |file: PathBuf| (module(&file), code(&fs::read_to_string(&file).unwrap()));
    let mut codes: BTreeMap<String, String> = sources(&app).into_iter().map(read).collect();
    // The root runs the window and is used by nothing.
    codes.remove("");
    assert!(codes.len() > 90, "{} files", codes.len());
    let circles = circles(imports(&codes));
    assert!(circles.is_empty(), "{circles:#?}");
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
