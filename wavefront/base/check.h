// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Check: a broken promise inside the program is a bug; it aborts with its values. Never use it for
// what a user or a file can cause.
#pragma once

#include <cstdio>
#include <cstdlib>

#define WAVEFRONT_CHECK(condition, ...)                                                       \
  do {                                                                                        \
    if (!(condition)) {                                                                       \
      std::fprintf(stderr, "%s:%d: check failed: %s: ", __FILE__, __LINE__, #condition);      \
      std::fprintf(stderr, __VA_ARGS__);                                                      \
      std::fputc('\n', stderr);                                                              \
      std::abort();                                                                           \
    }                                                                                         \
  } while (false)
