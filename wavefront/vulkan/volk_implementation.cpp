// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
//
// The one place that holds volk's function pointers and loader code.
#define VOLK_IMPLEMENTATION
#include <volk.h>
