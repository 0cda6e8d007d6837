//! The memory budget of a session.

use sysinfo::System;

/// Assumed memory where the system gives none, in bytes.
const UNKNOWN: u64 = 4 << 30;

/// A quarter of the memory available to this process, in bytes.
pub(super) fn quarter() -> usize {
    usize::try_from(memory() / 4).unwrap_or(usize::MAX)
}

/// The memory available to this process, in bytes.
pub fn memory() -> u64 {
    System::new().map_or(UNKNOWN, |mut system| {
        system.refresh_memory();
        let machine = system.total_memory();
        // A container may have less memory than the machine.
        system.cgroup_limits().map_or(machine, |limits| limits.total_memory.min(machine))
    })
}
