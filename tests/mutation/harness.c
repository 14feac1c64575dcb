/* Runs single tests of a unit test program on single mutants, as asked on standard input:
 *   list                   the tests' names, one a line, then an empty line
 *   reach TEST             runs it without a mutation: microseconds of processor time, or -1 where
 *                          it fails, and the numbers of the functions that it calls
 *   MUTANT LIMIT_MS TEST   runs it on a mutant: 1 passed, 0 not (failed, crashed, beyond the limit)
 * TEST is its place in the list. All mutants of a function are compiled into the program;
 * schemata.py makes the functions that choose between them by mutation_now. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <fcntl.h>
#include <unistd.h>

#include "unity.h"

#define TESTS 200
#define FUNCTIONS (1 << 16)
#define WALL_CLOCK_S 120U /* a mutant that waits for nothing uses no processor time */

unsigned mutation_now;
unsigned char *mutation_reached;
static unsigned char reached_before_main[FUNCTIONS];

static UnityTestFunction tests[TESTS];
static const char *names[TESTS];
static unsigned count;

__attribute__((constructor)) static void start(void)
{
    mutation_reached = reached_before_main;
}

void mutation_offer(UnityTestFunction test, const char *name)
{
    if (count == TESTS) {
        abort();
    }
    tests[count] = test;
    names[count++] = name;
}

/* Whether the test passes; the processor time that it took. */
static int run(const char *file, unsigned test, long limit_ms, long long *spent_us)
{
    struct rusage used;
    int status = 0;
    const pid_t child = fork();
    if (child == 0) {
        const struct itimerval limit = {{0, 0}, {limit_ms / 1000, limit_ms % 1000 * 1000}};
        const struct rlimit no_core = {0, 0};
        const int nowhere = open("/dev/null", O_RDWR);
        dup2(nowhere, 0);
        dup2(nowhere, 1);
        dup2(nowhere, 2);
        setrlimit(RLIMIT_CORE, &no_core);
        setitimer(ITIMER_PROF, &limit, NULL);
        alarm(WALL_CLOCK_S);
        UnityBegin(file);
        UnityDefaultTestRun(tests[test], names[test], 0);
        _exit(Unity.TestFailures != 0U);
    }
    if (child < 0 || wait4(child, &status, 0, &used) != child) {
        abort();
    }
    *spent_us = (used.ru_utime.tv_sec + used.ru_stime.tv_sec) * 1000000LL + used.ru_utime.tv_usec +
                used.ru_stime.tv_usec;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

int mutation_serve(const char *file)
{
    char line[80];
    long long spent_us;
    mutation_reached =
        mmap(NULL, FUNCTIONS, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (mutation_reached == MAP_FAILED) {
        return 1;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        unsigned mutant, test;
        long limit_ms;
        if (strcmp(line, "list\n") == 0) {
            for (unsigned i = 0; i < count; i++) {
                printf("%s\n", names[i]);
            }
            printf("\n");
        } else if (sscanf(line, "reach %u", &test) == 1 && test < count) {
            mutation_now = 0;
            memset(mutation_reached, 0, FUNCTIONS);
            const int passed = run(file, test, 300000, &spent_us);
            printf("%lld", passed ? spent_us : -1LL);
            for (unsigned i = 0; i < FUNCTIONS; i++) {
                if (mutation_reached[i] != 0U) {
                    printf(" %u", i);
                }
            }
            printf("\n");
        } else if (sscanf(line, "%u %ld %u", &mutant, &limit_ms, &test) == 3 && test < count) {
            mutation_now = mutant;
            printf("%d\n", run(file, test, limit_ms, &spent_us));
        } else {
            return 1;
        }
        fflush(stdout);
    }
    return 0;
}
