// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Operations of the expression DAG. One row per operation: how GLSL spells it, and how the CPU computes it.
#pragma once

#include <string_view>

#include "materialgen/type.h"

namespace materialgen {

// Arguments of an evaluation on the CPU.
struct OpArguments {
  const Constant* values[8];
  int components[8];
  int count = 0;
  int resultComponents = 0;
  std::string_view text;
};

struct Op {
  std::string_view name;
  // "$0 + $1": arguments by number, "$t" the expression's text, "$T" the result's type. Empty: the emitter knows it.
  std::string_view glsl;
  // One component at a time, scalars broadcast. Null: see `evaluate`.
  float (*component)(float a, float b, float c) = nullptr;
  // The whole value. Both null: only the kernel can compute it.
  void (*evaluate)(const OpArguments& arguments, Constant* result) = nullptr;
  bool infix = false;      // wants parentheses inside another expression
  bool sameTypes = false;  // GLSL has no overload that mixes scalars and vectors
};

// The row named `name`; naming one that is not there is a bug.
const Op& FindOp(std::string_view name);

}  // namespace materialgen
