/* Included before a unit test when mutants are tried: its main() does not run the tests but offers
 * them, one by one, each in a process of its own; see harness.c. */
#ifndef MUTATION_HARNESS_H
#define MUTATION_HARNESS_H

#include "unity.h"

void mutation_offer(UnityTestFunction test, const char *name);
int mutation_serve(const char *file);

#undef RUN_TEST
#undef UNITY_END
#define RUN_TEST(test) mutation_offer(test, #test)
#define UNITY_END() mutation_serve(__FILE__)

#endif
