// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Expressions as GLSL statements. No recursion: statements come in the order of ids.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "materialgen/ir.h"

namespace materialgen {

// Where uniform values and texture ids lie in the parameter block, and the primvars by slot; shared by all entries.
struct Layout {
  std::map<Id, uint32_t> offsets;  // in floats
  uint32_t floats = 0;             // a multiple of 4
  std::vector<std::string> primvars;
  uint32_t SlotOf(const std::string& primvar) const;
};
// The first `reserved` texels of the block stay free.
Layout LayOut(const Expressions& expressions, const std::vector<std::vector<Id>>& entries, uint32_t reserved);

class Printer {
 public:
  // Writes the statements that `roots` need, indented by two.
  Printer(const Expressions& expressions, const Layout& layout, const std::vector<Id>& roots);

  const std::string& Body() const { return body_; }
  std::string Text(Id id) const { return texts_.at(id).text; }
  std::string TextAs(Id id, Type type) const;
  const std::set<std::string>& LobeFiles() const { return lobeFiles_; }
  bool CallsLibrary() const { return callsLibrary_; }
  bool CallsHexTiles() const { return callsHexTiles_; }

 private:
  struct Printed {
    std::string text;
    bool infix = false;
  };
  void Print(Id id);
  Printed Write(const Expression& expression);
  std::string Substitute(const Expression& expression, const std::string& pattern,
                         const std::vector<std::string>& arguments) const;
  std::vector<std::string> Arguments(const Expression& expression) const;
  std::string Parameter(Id id);
  std::string ParameterTexel(uint32_t texel);
  void WriteFrame(const Expression& expression, const std::string& name);

  const Expressions& e_;
  const Layout& layout_;
  std::map<Id, Printed> texts_;
  std::map<Id, int> uses_;
  std::string parameters_, body_;
  std::set<uint32_t> texels_;
  std::set<std::string> lobeFiles_;
  bool callsLibrary_ = false, callsHexTiles_ = false;
  int values_ = 0, frames_ = 0, lobes_ = 0;
};

}  // namespace materialgen
