/// Widths of the lanes and their order; the steps themselves are in plant_step.h.
#include "plant_lanes.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "plant_generator.h"

// The widest instructions of the machine that runs it, chosen by the loader where it can.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__GLIBC__)
#define WIDEST __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define WIDE(name) __builtin_cpu_supports(name)
#else
#define WIDEST
#define WIDE(name) 0
#endif
#define INLINE static inline __attribute__((always_inline))

#define GRAVITY 9.81
#define AIR_DENSITY 1.2
#define SHAPE 1.35
#define TRAILER_AREA 5.0
#define SHORTEST_LAG_M 0.15
#define LIMIT 1e6
#define MAGIC 6755399441055744.0 // 1.5 * 2^52: in a sum with it, the last bits are an integer
#define LAW_SLOW 0.01        // rad/s, below which friction that grows with a deflection is not full
#define LAW_SPEED 25.0       // m/s, at which the gain of a law is said
#define SHORTEST_LAW_S 0.01  // lag of a law
#define SHORTEST_FELT_S 0.02 // lag of what is felt
#define FELT 3.0             // slot `law_transient` where what a law depends on is felt
#define OSCILLATES 4.0       // slot `law_transient` of a law that an oscillator of its own follows
#define BEHIND_S 0.03        // over which the rate is taken of what has none as a state
#define BY_ROLL(body) (1.0 + E_LAW_OF_ROLL_##body - E_LAW_OF_ARTICULATION) // slot `law_by` of it
// Shapes as numbered in discover/law.py: saturating, hysteretic, rubbing, waiting, limited rate,
// lost motion, falling, switched, free curve, stepped, notched.
#define SATURATES 1.0
#define STICKS 6.0
#define RUBS 7.0
#define WAITS 10.0
#define HURRIES 12.0
#define PLAYS 14.0
#define FALLS 15.0
#define SWITCHES 18.0
#define CURVE 19.0
#define STEPS 20.0
#define NOTCHES 21.0
#define BIT(shape) (1u << (uint32_t)(shape))
#define BENT (~(BIT(0.0) | BIT(CURVE)))
#define LEVELS (BIT(SATURATES) | BIT(RUBS) | BIT(WAITS) | BIT(FALLS) | BIT(SWITCHES) | BIT(STEPS))
#define KEEP (BIT(STICKS) | BIT(WAITS) | BIT(HURRIES) | BIT(PLAYS))
#define HURRY_S 0.05      // within which what may go as fast as it likes follows
#define PLAYED_S 0.02     // within which what is beyond the play is followed
#define PIECES 5          // of a free curve on each side, beside the first
#define STEEP 8.0         // times as fast as it falls, friction that falls with the rate rises
#define SWING_SEEN_S 0.05 // within which a law that waits notices how far something swings, ...
#define SWING_KEPT_S 1.0  // and forgets it: a swing of 1 Hz has two peaks a second
#define WAITING_SHARE 0.1 // of the swing at which it begins to act, over which it does
#define STEP_SHARE 0.03   // of a step, over which it rises
#define STEP_WHOLE 0.99999999999999334 // tanh(0.5 / STEP_SHARE)
#define SWITCHED_SHARE 0.1             // of what it switches at, over which it does
#define MODE_SLOW 0.01                 // m/s, below which friction on a floor is not full
#define DRAWBAR_LOSS_S 0.005           // damping over stiffness of a drawbar: steel with its joints
#define BALL_MEETS_M 3e-4  // m beyond its play, from which on a ball is held with the whole loss
#define BALL_RUBS 2e4      // Ns/m, of its friction where it hardly moves
#define LEAST_DRAWBAR 2e-6 // m/N, below which the motion of this one is scaled down: steps of 20 ms
#define RESOLVED 2         // trials of the drawbar's acceleration, and which one is the last

_Static_assert(E_SLOTS == PLANT_SCALARS, "every slot is read");

static const double NEUTRAL = 0.0;

#define WIDTH 8
#define NAME(name) name##_8
#include "plant_step.h"
#undef WIDTH
#undef NAME
#define WIDTH 4
#define NAME(name) name##_4
#include "plant_step.h"
#undef WIDTH
#undef NAME
#define WIDTH 2
#define NAME(name) name##_2
#include "plant_step.h"
#undef WIDTH
#undef NAME

/// Lanes that a register holds: what compares wider rows is compiled to one lane after the other.
static int32_t widest(void)
{
    if (WIDE("avx512dq")) {
        return 8;
    }
    return WIDE("avx2") ? 4 : 2;
}

static void run(plant_lane_t *const *lanes, int32_t count, double period_s, int32_t stride,
                int64_t steps)
{
    const int32_t width = widest();
    for (int32_t first = 0; first < count; first += width) {
        const int32_t some = count - first < width ? count - first : width;
        if (some > 4) {
            advance_8(lanes + first, some, period_s, stride, steps);
        } else if (some > 2) {
            advance_4(lanes + first, some, period_s, stride, steps);
        } else {
            advance_2(lanes + first, some, period_s, stride, steps);
        }
    }
}

/// Last samples of a lane, after its steps of `stride`.
static void finish(plant_lane_t *lane, double period_s)
{
    if (lane->stop - 1 - lane->at > 0 && lane->diverged == 0) {
        run(&lane, 1, period_s, 1, lane->stop - 1 - lane->at);
    }
    if (lane->diverged == 0) {
        run(&lane, 1, period_s, 0, 1);
    }
    const int64_t open = (lane->stop - lane->first) % PLANT_BLOCK;
    if (open != 0 && lane->blocks != NULL) {
        memcpy(lane->blocks + (lane->stop - 1) / PLANT_BLOCK * PLANT_SUMS, lane->sums,
               sizeof lane->sums);
    }
}

void plant_lanes(plant_lane_t *lanes, int32_t count, double period_s, int32_t stride)
{
    plant_lane_t *active[PLANT_LANES];
    int32_t left = 0;
    for (int32_t i = 0; i < count && i < PLANT_LANES; i++) {
        lanes[i].at = lanes[i].first;
        active[left++] = &lanes[i];
    }
    while (left > 0) {
        int64_t common = INT64_MAX;
        for (int32_t i = 0; i < left; i++) {
            const int64_t steps = (active[i]->stop - 1 - active[i]->at) / stride;
            common = steps < common ? steps : common;
        }
        if (common > 0) {
            run(active, left, period_s, stride, common);
        }
        int32_t kept = 0;
        for (int32_t i = 0; i < left; i++) {
            if (active[i]->stop - 1 - active[i]->at < stride || active[i]->diverged != 0) {
                finish(active[i], period_s);
            } else {
                active[kept++] = active[i];
            }
        }
        left = kept;
    }
}
