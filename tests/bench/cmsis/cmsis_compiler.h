/* What CMSIS-DSP wants of a compiler, by the Arm C language extensions. Only for the benchmark. */
#ifndef CMSIS_COMPILER_H
#define CMSIS_COMPILER_H

#include <arm_acle.h>
#include <stdint.h>

#define __ASM __asm__ volatile
#define __STATIC_FORCEINLINE static inline __attribute__((always_inline))
#define __STATIC_INLINE static inline
#define __ALIGNED(n) __attribute__((aligned(n)))
#define __WEAK __attribute__((weak))
#define __CLZ(x) ((uint8_t)((x) == 0U ? 32 : __builtin_clz(x)))

#if defined(__ARM_FEATURE_DSP)
#define __QADD16(a, b) ((uint32_t)__qadd16((int16x2_t)(a), (int16x2_t)(b)))
#define __QSUB16(a, b) ((uint32_t)__qsub16((int16x2_t)(a), (int16x2_t)(b)))
#define __SHADD16(a, b) ((uint32_t)__shadd16((int16x2_t)(a), (int16x2_t)(b)))
#define __SHSUB16(a, b) ((uint32_t)__shsub16((int16x2_t)(a), (int16x2_t)(b)))
#define __QASX(a, b) ((uint32_t)__qasx((int16x2_t)(a), (int16x2_t)(b)))
#define __QSAX(a, b) ((uint32_t)__qsax((int16x2_t)(a), (int16x2_t)(b)))
#define __SHASX(a, b) ((uint32_t)__shasx((int16x2_t)(a), (int16x2_t)(b)))
#define __SHSAX(a, b) ((uint32_t)__shsax((int16x2_t)(a), (int16x2_t)(b)))
#define __SMUAD(a, b) ((uint32_t)__smuad((int16x2_t)(a), (int16x2_t)(b)))
#define __SMUSD(a, b) ((uint32_t)__smusd((int16x2_t)(a), (int16x2_t)(b)))
#define __SMUADX(a, b) ((uint32_t)__smuadx((int16x2_t)(a), (int16x2_t)(b)))
#define __SMUSDX(a, b) ((uint32_t)__smusdx((int16x2_t)(a), (int16x2_t)(b)))
#define __SMLAD(a, b, c) ((uint32_t)__smlad((int16x2_t)(a), (int16x2_t)(b), (int32_t)(c)))
#define __SMLADX(a, b, c) ((uint32_t)__smladx((int16x2_t)(a), (int16x2_t)(b), (int32_t)(c)))
#define __SMLALD(a, b, c) ((uint64_t)__smlald((int16x2_t)(a), (int16x2_t)(b), (int64_t)(c)))
#define __SMLALDX(a, b, c) ((uint64_t)__smlaldx((int16x2_t)(a), (int16x2_t)(b), (int64_t)(c)))
#define __SXTB16(a) ((uint32_t)__sxtb16((int8x4_t)(a)))
#define __QADD8(a, b) ((uint32_t)__qadd8((int8x4_t)(a), (int8x4_t)(b)))
#define __QSUB8(a, b) ((uint32_t)__qsub8((int8x4_t)(a), (int8x4_t)(b)))
#define __QADD(a, b) __qadd(a, b)
#define __QSUB(a, b) __qsub(a, b)
#define __SSAT(a, n) __ssat(a, n)
#define __USAT(a, n) __usat(a, n)
#define __PKHBT(a, b, n)                                                                           \
    ((((uint32_t)(a)) & 0x0000FFFFU) | ((((uint32_t)(b)) << (n)) & 0xFFFF0000U))
#define __PKHTB(a, b, n) ((((uint32_t)(a)) & 0xFFFF0000U) | ((((int32_t)(b)) >> (n)) & 0x0000FFFFU))
#else
static inline int32_t sway_saturate(int32_t value, uint32_t bits)
{
    const int32_t top = (int32_t)((1U << (bits - 1U)) - 1U);
    return value > top ? top : value < -top - 1 ? -top - 1 : value;
}
#define __SSAT(a, n) sway_saturate(a, n)
#endif
#define __ROR(a, n) (((uint32_t)(a) >> (n)) | ((uint32_t)(a) << (32U - (n))))

#endif
