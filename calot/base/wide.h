// Functions for wider registers where the processor has them.
#pragma once

/// Before a function: it is compiled for AVX2 too, and the processor chooses. The arithmetic is the same; without
/// contraction, which the build switches off, so are the bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define CALOT_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define CALOT_WIDE
#endif
