// A layer between the program and the system, loaded by LD_PRELOAD: lets one call fail, all from one on, or kills the process
// there. Calls below a folder are counted from 1, of the kinds that are asked for. Environment:
//
//   OCCLUSCOPE_FAULT_UNDER    the folder
//   OCCLUSCOPE_FAULT_CALLS    the kinds: open (to write), write, sync, close, rename, link, mkdir, read (and open to read)
//   OCCLUSCOPE_FAULT_AT       the number of the call; 0 for none
//   OCCLUSCOPE_FAULT_LASTS    1: later calls fail as well
//   OCCLUSCOPE_FAULT_ERROR    the number of the error; 0 kills the process
//   OCCLUSCOPE_FAULT_COUNT    a file that gets the number of counted calls at the end of the process

#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static const char *under, *calls, *count_file;
static long at, lasts, error_number;
static long counted;

__attribute__((constructor)) static void begin(void) {
    under = getenv("OCCLUSCOPE_FAULT_UNDER");
    calls = getenv("OCCLUSCOPE_FAULT_CALLS");
    count_file = getenv("OCCLUSCOPE_FAULT_COUNT");
    const char *text;
    at = (text = getenv("OCCLUSCOPE_FAULT_AT")) ? atol(text) : 0;
    lasts = (text = getenv("OCCLUSCOPE_FAULT_LASTS")) ? atol(text) : 0;
    error_number = (text = getenv("OCCLUSCOPE_FAULT_ERROR")) ? atol(text) : EIO;
}

__attribute__((destructor)) static void end(void) {
    if (!count_file) return;
    char text[32];
    int length = snprintf(text, sizeof text, "%ld", __sync_fetch_and_add(&counted, 0));
    int file = syscall(SYS_openat, AT_FDCWD, count_file, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (file >= 0 && syscall(SYS_write, file, text, length) == length) syscall(SYS_close, file);
}

static int is_below(const char *path) {
    if (!under || !path) return 0;
    size_t length = strlen(under);
    return strncmp(path, under, length) == 0 && (path[length] == '/' || path[length] == 0);
}

static int is_file_below(int file) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return is_below(path);
}

// Counts a call of this kind; whether it fails: 1 for the first that does, 2 for later ones.
static int fails(const char *kind) {
    const char *found = calls ? strstr(calls, kind) : NULL;
    if (!found) return 0;
    long number = __sync_add_and_fetch(&counted, 1);
    if (at == 0 || number < at || (number > at && !lasts)) return 0;
    if (error_number == 0) kill(getpid(), SIGKILL);
    errno = error_number;
    return number == at ? 1 : 2;
}

static int open_at(int folder, const char *path, int flags, mode_t mode) {
    int saved = errno;
    int writes = (flags & O_ACCMODE) != O_RDONLY;
    if ((folder == AT_FDCWD || path[0] == '/') && is_below(path) && !(flags & O_PATH)) {
        int is_folder = (flags & O_DIRECTORY) && (flags & O_TMPFILE) != O_TMPFILE;
        if (!is_folder && fails(writes ? "open" : "read")) return -1;
    }
    errno = saved;
    return syscall(SYS_openat, folder, path, flags, mode);
}

#define MODE                                                                          \
    mode_t mode = 0;                                                                  \
    if ((flags & O_CREAT) || (flags & O_TMPFILE) == O_TMPFILE) {                      \
        va_list rest;                                                                 \
        va_start(rest, flags);                                                        \
        mode = va_arg(rest, mode_t);                                                  \
        va_end(rest);                                                                 \
    }

int open(const char *path, int flags, ...) { MODE return open_at(AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { MODE return open_at(AT_FDCWD, path, flags | O_LARGEFILE, mode); }
int openat(int folder, const char *path, int flags, ...) { MODE return open_at(folder, path, flags, mode); }
int openat64(int folder, const char *path, int flags, ...) {
    MODE return open_at(folder, path, flags | O_LARGEFILE, mode);
}
int creat(const char *path, mode_t mode) { return open_at(AT_FDCWD, path, O_CREAT | O_WRONLY | O_TRUNC, mode); }
int creat64(const char *path, mode_t mode) { return creat(path, mode); }

// A disk that becomes full takes a part of the bytes first.
static int takes_half(int failing) { return failing == 1 && lasts; }

ssize_t write(int file, const void *bytes, size_t length) {
    int failing = is_file_below(file) ? fails("write") : 0;
    if (failing && !(takes_half(failing) && length > 1)) return -1;
    return syscall(SYS_write, file, bytes, failing ? length / 2 : length);
}
ssize_t pwrite64(int file, const void *bytes, size_t length, off64_t offset) {
    int failing = is_file_below(file) ? fails("write") : 0;
    if (failing && !(takes_half(failing) && length > 1)) return -1;
    return syscall(SYS_pwrite64, file, bytes, failing ? length / 2 : length, offset);
}
ssize_t pwrite(int file, const void *bytes, size_t length, off_t offset) {
    return pwrite64(file, bytes, length, offset);
}
ssize_t writev(int file, const struct iovec *parts, int count) {
    if (is_file_below(file) && fails("write")) return -1;
    return syscall(SYS_writev, file, parts, count);
}
ssize_t copy_file_range(int from, off64_t *at_from, int to, off64_t *at_to, size_t length, unsigned flags) {
    if (is_file_below(to) && fails("write")) return -1;
    return syscall(SYS_copy_file_range, from, at_from, to, at_to, length, flags);
}
int ftruncate64(int file, off64_t length) { return syscall(SYS_ftruncate, file, length); }

ssize_t read(int file, void *bytes, size_t length) {
    if (is_file_below(file) && fails("read")) return -1;
    return syscall(SYS_read, file, bytes, length);
}
ssize_t pread64(int file, void *bytes, size_t length, off64_t offset) {
    if (is_file_below(file) && fails("read")) return -1;
    return syscall(SYS_pread64, file, bytes, length, offset);
}
ssize_t pread(int file, void *bytes, size_t length, off_t offset) { return pread64(file, bytes, length, offset); }

int fsync(int file) {
    if (is_file_below(file) && fails("sync")) return -1;
    return syscall(SYS_fsync, file);
}
int fdatasync(int file) {
    if (is_file_below(file) && fails("sync")) return -1;
    return syscall(SYS_fdatasync, file);
}
int close(int file) {
    int failing = is_file_below(file) && (fcntl(file, F_GETFL) & O_ACCMODE) != O_RDONLY ? fails("close") : 0;
    int saved = errno;
    int result = syscall(SYS_close, file);
    if (!failing) return result;
    errno = saved;
    return -1;
}

int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags) {
    if ((is_below(from) || is_below(to)) && fails("rename")) return -1;
    return syscall(SYS_renameat2, from_folder, from, to_folder, to, flags);
}
int renameat(int from_folder, const char *from, int to_folder, const char *to) {
    return renameat2(from_folder, from, to_folder, to, 0);
}
int rename(const char *from, const char *to) { return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0); }
int linkat(int from_folder, const char *from, int to_folder, const char *to, int flags) {
    if (is_below(to) && fails("link")) return -1;
    return syscall(SYS_linkat, from_folder, from, to_folder, to, flags);
}
int link(const char *from, const char *to) { return linkat(AT_FDCWD, from, AT_FDCWD, to, 0); }
int mkdirat(int folder, const char *path, mode_t mode) {
    if (is_below(path) && fails("mkdir")) return -1;
    return syscall(SYS_mkdirat, folder, path, mode);
}
int mkdir(const char *path, mode_t mode) { return mkdirat(AT_FDCWD, path, mode); }
