/* LD_PRELOAD: the wall clock of a process, moved by a number of seconds that a test changes while it runs.

   FES_JUMPED_CLOCK names a file with one 64-bit offset [s] per kind of process, in the order of KINDS: the first
   whose mark is in the command line. All other clocks stay as they are. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const char *const KINDS[] = {"field.gate", "world.tabletop", "field"};
enum { COUNT = 3 };

static const volatile int64_t *offset;

__attribute__((constructor)) static void open_offset(void) {
    char line[4096];
    const char *path = getenv("FES_JUMPED_CLOCK");
    int file = open("/proc/self/cmdline", O_RDONLY | O_CLOEXEC);
    ssize_t length = file < 0 ? -1 : read(file, line, sizeof line - 1);
    if (file >= 0) close(file);
    if (path == NULL || length <= 0) return;
    for (ssize_t at = 0; at < length; at++)
        if (line[at] == '\0') line[at] = ' ';
    line[length] = '\0';
    for (int kind = 0; kind < COUNT; kind++) {
        if (strstr(line, KINDS[kind]) == NULL) continue;
        file = open(path, O_RDONLY | O_CLOEXEC);
        void *place = file < 0 ? MAP_FAILED : mmap(NULL, COUNT * sizeof *offset, PROT_READ, MAP_SHARED, file, 0);
        if (file >= 0) close(file);
        if (place == MAP_FAILED) abort(); /* a test without its jump would prove nothing */
        offset = (const volatile int64_t *)place + kind;
        return;
    }
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    int result = (int)syscall(SYS_clock_gettime, clock, now);
    if (result == 0 && offset != NULL && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
        now->tv_sec += *offset;
    return result;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    struct timespec exact;
    (void)zone;
    if (clock_gettime(CLOCK_REALTIME, &exact) != 0) return -1;
    now->tv_sec = exact.tv_sec;
    now->tv_usec = exact.tv_nsec / 1000;
    return 0;
}

time_t time(time_t *now) {
    struct timespec exact;
    if (clock_gettime(CLOCK_REALTIME, &exact) != 0) return (time_t)-1;
    if (now != NULL) *now = exact.tv_sec;
    return exact.tv_sec;
}
