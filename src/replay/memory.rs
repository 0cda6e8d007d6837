//! How much memory a session may take.

use sysinfo::System;

/// What is assumed of a machine that does not tell.
const UNKNOWN: u64 = 4 << 30;

/// A quarter of the memory that this process may use, in bytes.
pub(super) fn quarter() -> usize {
    usize::try_from(memory() / 4).unwrap_or(usize::MAX)
}

/// The memory that this process may use, in bytes.
pub fn memory() -> u64 {
    System::new().map_or(UNKNOWN, |mut system| {
        system.refresh_memory();
        let machine = system.total_memory();
        // A container may be given less than the machine has.
        system.cgroup_limits().map_or(machine, |limits| limits.total_memory.min(machine))
    })
}
