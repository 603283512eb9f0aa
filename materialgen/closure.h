// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Closure tree of one material and its linearisation: each lobe with one weight expression.
#pragma once

#include <string_view>
#include <vector>

#include "materialgen/ir.h"

namespace materialgen {

// One kind of lobe: a file of wavefront/kernels/lib/bsdf.
struct LobeKind {
  std::string_view name;       // file name, and name in statistics
  std::string_view function;   // "fooMake", "fooEval", ... start with it
  std::string_view structure;  // "FooLobe"
  bool transmits = false;      // sees the other side of a closed boundary
  bool opaque = false;         // lets nothing through to what it is layered over
  bool thin = false;           // transmits, but into no body: a thin-walled surface has no inside
};
const LobeKind& FindLobe(std::string_view name);

using BsdfId = uint32_t;

// A homogeneous medium; kNone: zero.
struct Vdf {
  Id absorption = kNone, scattering = kNone;  // 1 / scene unit
  Id anisotropy = kNone;                      // mean cosine of Henyey and Greenstein's phase function
};
Vdf Sum(Expressions& e, const Vdf& a, const Vdf& b);
Vdf Scaled(Expressions& e, const Vdf& v, Id factor);

// A node of the closure tree (a DAG: a BSDF may be used twice). Children come before parents.
struct Bsdf {
  enum class Kind : uint8_t { Lobe, PassThrough, Layer, Mix, Add, Scale, Volume, ThinWall };
  Kind kind = Kind::Lobe;
  BsdfId first = kNone;   // Layer: top; Mix: foreground; Add, Scale, Volume, ThinWall: of a thin-walled surface
  BsdfId second = kNone;  // Layer: base; Mix: background; Add
  Id factor = kNone;      // Mix: amount; Scale: colour or scalar
  Vdf inside;             // Volume
  const LobeKind* lobe = nullptr;
  Id expression = kNone;    // Lobe: the "lobe" expression
  Id weight = kNone;        // Lobe: scalar weight, which also scales what it takes from below
  Id tint = kNone;          // Lobe: colour of the response only (MaterialX: takes nothing from below)
  // Lobe of an interface: its index, or colour at normal incidence, to know R and T lobes of the same interface.
  Id interface = kNone;
  Id withoutFilm = kNone;   // Reflecting lobe of a dielectric under a thin film: the same without film
  Id bodyIor = kNone;       // Lobe that transmits: the index of the inside
};

struct WeightedLobe {
  const LobeKind* lobe = nullptr;
  Id expression = kNone;
  Id weight = kNone;
};

struct LinearClosure {
  std::vector<WeightedLobe> lobes;  // in order of creation
  Id passThrough = kNone;           // weight of light that passes straight through; kNone: none
  Vdf inside;                       // where it transmits
  Id bodyIor = kNone;
  bool transmits = false;           // into a body
  bool hasSubsurface = false;       // some lobe leads to a random walk
  bool isThinWalled = false;        // most of what is transmitted enters no body
  bool mixesWalls = false;          // some of it is, some is not
  bool mixesIndices = false;        // bodies of several indices: bodyIor is that of the greatest part
};

// inside.cpp: fills in what lies behind the lobes that transmit. `live`: nodes that are lobes of the result.
void FindInside(Expressions* expressions, const std::vector<Bsdf>& nodes, BsdfId root, const std::vector<bool>& live,
                LinearClosure* result);

// `root` may be kNone (no BSDF). Lobes whose weight is zero for this material are left out.
LinearClosure Linearise(Expressions* expressions, const std::vector<Bsdf>& nodes, BsdfId root);

}  // namespace materialgen
