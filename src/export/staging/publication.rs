//! Moves staged files to their places, all of them or none.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::hidden_folder::{HiddenFolder, undisturbed};
use super::target::{check_file, check_folder};
use super::{Replace, is_numbered_picture};
use crate::export::write_failure::{describe, describe_with_kept};

/// A publication renames files that are on the disk already: longer than this none takes.
const LONGEST_TURN: Duration = Duration::from_secs(10);

/// A step of a publication.
enum Step {
    /// Moves a file or a folder that is not there yet.
    Place { from: PathBuf, to: PathBuf },
    /// Removes a file of an earlier set.
    Remove(PathBuf),
}

/// What reverses a step.
enum Undo {
    /// Moves what was kept back to its place, in place of the new file.
    PutBack { kept: PathBuf, to: PathBuf },
    /// Moves the new file or folder away.
    TakeAway { at: PathBuf, to: PathBuf },
    /// Removes a second name of the new file.
    Unlink(PathBuf),
}

/// Moves everything that is staged in `hidden` into `folder`, `last` at the end. On an error everything is as before.
pub(super) fn publish(hidden: HiddenFolder, folder: &Path, last: &Path, replace: Replace) -> io::Result<()> {
    let (staged, kept) = (hidden.new_files(), hidden.old_files());
    sync(&staged)?;
    // Two processes that publish into a folder at the same time would leave a mixture of both sets.
    let _turn = turn(folder);
    let steps = steps(&staged, folder, last)?;
    check(&steps, &hidden)?;
    let failure = undisturbed(|| carry_out(&steps, &kept, folder, replace));
    let Err(Failure { error, is_undone }) = failure else { return Ok(()) };
    if is_undone {
        return Err(error);
    }
    hidden.leave();
    Err(describe_with_kept(folder, error, &kept))
}

/// Waits until everything below `folder` is on the disk.
fn sync(folder: &Path) -> io::Result<()> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    let mut index = 0;
    while let Some(next) = folders.get(index).cloned() {
        for entry in fs::read_dir(&next).map_err(|error| describe(&next, error))? {
            let path = entry.map_err(|error| describe(&next, error))?.path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
        index += 1;
    }
    // It waits more than it works, and the disk takes many files at once.
    files.par_iter().try_for_each(|path| {
        // Reports an error of an earlier write to the file.
        let file = File::options().write(true).open(path);
        file.and_then(|file| file.sync_all()).map_err(|error| describe(path, error))
    })?;
    folders.iter().try_for_each(|path| sync_folder(path))
}

/// Waits until the names in a folder are on the disk.
fn sync_folder(path: &Path) -> io::Result<()> {
    // Other systems open no folders.
    if !cfg!(unix) {
        return Ok(());
    }
    let synced = File::open(path).and_then(|folder| folder.sync_all());
    synced.or_else(|error| match error.kind() {
        // Some disks of the network do it in any case.
        io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
        _ => Err(describe(path, error)),
    })
}

/// The turn to publish into `folder`, which ends when it is dropped; `None` where there are no locks, and where another
/// program keeps one on the folder for longer than a publication takes.
fn turn(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    let until = Instant::now() + LONGEST_TURN;
    loop {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) if Instant::now() < until => {
                thread::sleep(Duration::from_millis(20));
            }
            Err(_) => return None,
        }
    }
}

/// The steps that move what is in `staged` into `folder`, in the order in which they are done.
fn steps(staged: &Path, folder: &Path, last: &Path) -> io::Result<Vec<Step>> {
    let (mut steps, mut removals) = (Vec::new(), Vec::new());
    add_steps(staged, folder, &mut steps, &mut removals)?;
    let last = folder.join(last);
    let is_last = |step: &Step| matches!(step, Step::Place { to, .. } if *to == last);
    let (at_the_end, others): (Vec<_>, Vec<_>) = steps.into_iter().partition(is_last);
    let mut steps = Vec::new();
    // Where the last file exists, the set is complete: an earlier one is removed first.
    if !others.is_empty() && fs::symlink_metadata(&last).is_ok() {
        steps.push(Step::Remove(last));
    }
    steps.extend(others);
    steps.extend(removals);
    steps.extend(at_the_end);
    Ok(steps)
}

fn add_steps(
    staged: &Path,
    folder: &Path,
    steps: &mut Vec<Step>,
    removals: &mut Vec<Step>,
) -> io::Result<()> {
    for name in &names(staged)? {
        let (from, to) = (staged.join(name), folder.join(name));
        if from.is_dir() && to.is_dir() {
            add_steps(&from, &to, steps, removals)?;
            add_removals(&names(&from)?, &to, removals)?;
        } else {
            steps.push(Step::Place { from, to });
        }
    }
    Ok(())
}

/// In a folder of results a set of numbered pictures, `new`, replaces the whole earlier set.
fn add_removals(new: &[OsString], folder: &Path, removals: &mut Vec<Step>) -> io::Result<()> {
    if new.iter().any(|name| is_numbered_picture(&name.to_string_lossy())) {
        let earlier = names(folder)?.into_iter();
        let is_left = |name: &OsString| {
            is_numbered_picture(&name.to_string_lossy()) && new.binary_search(name).is_err()
        };
        removals.extend(earlier.filter(is_left).map(|name| Step::Remove(folder.join(name))));
    }
    Ok(())
}

/// The names in a folder, in order.
fn names(folder: &Path) -> io::Result<Vec<OsString>> {
    let entries = fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<_>>>());
    let mut names = entries.map_err(|error| describe(folder, error))?;
    names.sort();
    Ok(names)
}

/// Whether all steps can be done, as far as it can be known before.
fn check(steps: &[Step], hidden: &HiddenFolder) -> io::Result<()> {
    let own = fs::metadata(hidden.path()).map_err(|error| describe(hidden.path(), error))?;
    for step in steps {
        match step {
            Step::Place { from, to } if from.is_dir() => check_folder(to, &own, |_| false)?,
            Step::Place { to, .. } => check_file(to, &own)?,
            Step::Remove(at) => check_file(at, &own)?,
        }
    }
    Ok(())
}

/// An error, and whether all earlier steps could be reversed.
struct Failure {
    error: io::Error,
    is_undone: bool,
}

/// Does the steps. Until all are done and on the disk, `kept` holds what they replace.
fn carry_out(steps: &[Step], kept: &Path, folder: &Path, replace: Replace) -> Result<(), Failure> {
    let mut done = Vec::new();
    let all = steps.iter().zip(0_u32..).try_for_each(|(step, index)| {
        done.push(step.carry_out(&kept.join(index.to_string()), replace)?);
        Ok(())
    });
    let Err(error) = all.and_then(|()| sync_changed(steps, folder)) else { return Ok(()) };
    let mut is_undone = true;
    for undo in done.iter().rev() {
        is_undone &= undo.carry_out().is_ok();
    }
    Err(Failure { error, is_undone })
}

/// Waits until the changed names are on the disk.
fn sync_changed(steps: &[Step], folder: &Path) -> io::Result<()> {
    let changed = steps.iter().filter_map(|step| match step {
        Step::Place { to, .. } | Step::Remove(to) => to.parent(),
    });
    let mut folders: Vec<&Path> = changed.filter(|parent| !parent.as_os_str().is_empty()).collect();
    folders.push(folder);
    folders.sort_unstable();
    folders.dedup();
    folders.into_iter().try_for_each(sync_folder)
}

impl Step {
    /// Does the step; what it replaces is at `kept` until then.
    fn carry_out(&self, kept: &Path, replace: Replace) -> io::Result<Undo> {
        match self {
            Self::Place { from, to } if replace == Replace::No => {
                place_beside(from, to).map_err(|error| describe(to, error))
            }
            Self::Place { from, to } => place(from, to, kept).map_err(|error| describe(to, error)),
            Self::Remove(at) => {
                fs::rename(at, kept).map_err(|error| describe(at, error))?;
                Ok(Undo::PutBack { kept: kept.to_owned(), to: at.clone() })
            }
        }
    }
}

/// Moves a file or folder to its place. Where the disk has second names, a file that is there has its name until the new
/// one has it.
fn place(from: &Path, to: &Path, kept: &Path) -> io::Result<Undo> {
    let replaces = fs::symlink_metadata(to).is_ok();
    if replaces {
        // Some disks have no second names, and some systems refuse one for another user's file.
        fs::hard_link(to, kept).or_else(|_| fs::rename(to, kept))?;
    }
    if let Err(error) = fs::rename(from, to) {
        if fs::symlink_metadata(to).is_err() {
            fs::rename(kept, to)?;
        }
        return Err(error);
    }
    Ok(if replaces {
        Undo::PutBack { kept: kept.to_owned(), to: to.to_owned() }
    } else {
        Undo::TakeAway { at: to.to_owned(), to: from.to_owned() }
    })
}

/// Gives a new file its name, which must not exist.
fn place_beside(from: &Path, to: &Path) -> io::Result<Undo> {
    match fs::hard_link(from, to) {
        Ok(()) => Ok(Undo::Unlink(to.to_owned())),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        Err(_) if fs::symlink_metadata(to).is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => {
            fs::rename(from, to)?;
            Ok(Undo::TakeAway { at: to.to_owned(), to: from.to_owned() })
        }
    }
}

impl Undo {
    fn carry_out(&self) -> io::Result<()> {
        match self {
            Self::PutBack { kept, to } => fs::rename(kept, to),
            Self::TakeAway { at, to } => fs::rename(at, to),
            Self::Unlink(at) => fs::remove_file(at),
        }
    }
}
