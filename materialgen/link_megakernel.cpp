// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/link_megakernel.h"

#include <array>
#include <cctype>
#include <vector>

#include "materialgen/embedded_glsl.h"
#include "materialgen/materialgen.h"

namespace materialgen {
namespace {

bool IsNameStart(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool IsNamePart(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

struct Token {
  std::string_view text;  // a name, a number, or one character
  size_t at;
};

// Comments and preprocessor lines are no tokens.
std::vector<Token> Tokens(std::string_view text) {
  std::vector<Token> tokens;
  bool isLineStart = true;
  for (size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '\n') isLineStart = true;
    if (std::isspace(static_cast<unsigned char>(c))) { ++i; continue; }
    if (c == '#' && isLineStart) {
      while (i < text.size() && !(text[i] == '\n' && text[i - 1] != '\\')) ++i;
      continue;
    }
    isLineStart = false;
    if (text.substr(i, 2) == "//") {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (text.substr(i, 2) == "/*") {
      const size_t end = text.find("*/", i);
      i = end == std::string_view::npos ? text.size() : end + 2;
      continue;
    }
    size_t end = i + 1;
    if (IsNamePart(c)) while (end < text.size() && (IsNamePart(text[end]) || (!IsNameStart(c) && text[end] == '.'))) ++end;
    tokens.push_back({text.substr(i, end - i), i});
    i = end;
  }
  return tokens;
}

// Index behind the bracket that closes the one at `open`.
size_t Behind(const std::vector<Token>& tokens, size_t open) {
  int depth = 0;
  for (size_t i = open; i < tokens.size(); ++i) {
    const char c = tokens[i].text[0];
    if (c == '(' || c == '[' || c == '{') ++depth;
    if ((c == ')' || c == ']' || c == '}') && --depth == 0) return i + 1;
  }
  return tokens.size();
}

// A source of generator.cpp in its parts.
struct SourceParts {
  std::vector<std::string> includes;  // of the head
  std::string body;
  std::string tail;                   // name of the last include
};
SourceParts Split(const std::string& source) {
  SourceParts parts;
  for (size_t at = 0; at < source.size();) {
    const size_t end = std::min(source.find('\n', at), source.size());
    const std::string_view line = std::string_view(source).substr(at, end - at);
    at = end + 1;
    if (line.starts_with("#version") || line.starts_with("#extension")) continue;
    if (!line.starts_with("#include")) {
      parts.body.append(line).push_back('\n');
      continue;
    }
    const size_t open = line.find('"') + 1;
    const std::string name(line.substr(open, line.find('"', open) - open));
    if (name.ends_with("_tail.glsl")) parts.tail = name;
    else parts.includes.push_back(name);
  }
  return parts;
}

}  // namespace

std::set<std::string> TopLevelNames(std::string_view text) {
  const std::vector<Token> tokens = Tokens(text);
  std::set<std::string> names;
  std::string_view last;  // name before the token, in the declaration that is being read
  bool isNamed = false;   // its name is known: what follows is a value or a body
  for (size_t i = 0; i < tokens.size();) {
    const char c = tokens[i].text[0];
    if (IsNameStart(c)) {
      if (last == "struct") names.emplace(tokens[i].text);
      last = tokens[i].text;
      ++i;
    } else if (c == '(' || c == '=' || c == ';' || c == '[' || c == ',' || c == '{') {
      if (c == '(' && last == "layout") { i = Behind(tokens, i); continue; }
      if (last == "in") last = {};  // layout(local_size_x = 64) in;
      if (c != '{' && !isNamed && !last.empty()) names.emplace(last);
      isNamed = c != ';' && c != '{' && c != ',';
      if (c == '(' || c == '[') i = Behind(tokens, i);
      else if (c == '{') i = Behind(tokens, i);
      else ++i;
      if (c == '{' || c == ';') { last = {}; isNamed = false; }
    } else {
      ++i;
    }
  }
  return names;
}

std::string WithCountedLoops(std::string_view text) {
  const std::vector<Token> tokens = Tokens(text);
  std::string result;
  size_t done = 0;
  const auto copy = [&](size_t end) {
    result += text.substr(done, end - done);
    done = end;
  };
  for (size_t i = 0; i + 1 < tokens.size(); ++i) {
    const bool isFor = tokens[i].text == "for";
    if ((!isFor && tokens[i].text != "while") || tokens[i + 1].text != "(") continue;
    size_t begin = i + 2;  // of the condition
    const size_t close = Behind(tokens, i + 1) - 1;
    size_t end = close;
    if (isFor) {
      const auto next = [&](size_t from) {
        while (from < close && tokens[from].text != ";") from = tokens[from].text == "(" ? Behind(tokens, from) : from + 1;
        return from;
      };
      begin = next(begin) + 1;
      end = next(begin);
    }
    if (end >= tokens.size()) break;
    if (begin == end) {
      copy(tokens[end].at);
      result += " countLoop()";
      continue;
    }
    copy(tokens[begin].at);
    result += "countLoop() && (";
    copy(tokens[end].at);
    result += ")";
  }
  copy(text.size());
  return result;
}

std::string LinkMegakernel(const std::vector<std::shared_ptr<const KernelSource>>& kernels) {
  static constexpr std::array<const char*, kKernelEntries> kNames{"Surface", "Opacity", "Emission"};
  std::string text =
      "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"megakernel/head.glsl\"\n";
  std::string includes, constants, bodies, calls;
  std::set<std::string> included;
  for (size_t k = 0; k < kernels.size(); ++k) {
    const std::array<const std::string*, kKernelEntries> sources{&kernels[k]->surface, &kernels[k]->opacity, &kernels[k]->emission};
    for (size_t entry = 0; entry < kKernelEntries; ++entry) {
      if (sources[entry]->empty()) continue;
      const SourceParts parts = Split(*sources[entry]);
      for (const std::string& name : parts.includes)
        if (included.insert(name).second) includes += "#include \"" + name + "\"\n";
      // What the material and the tail declare gets the names of this material; the libraries above are common to all.
      std::string prefix = "m";
      prefix += std::to_string(k) + kNames[entry] + "_";
      std::set<std::string> names = TopLevelNames(parts.body);
      names.merge(TopLevelNames(EmbeddedGlsl("kernels/" + parts.tail)));
      for (const std::string& name : names) bodies += "#define " + name + " " + prefix + name + "\n";
      bodies += WithCountedLoops(parts.body) + "#include \"" + parts.tail + "\"\n";
      for (const std::string& name : names) bodies += "#undef " + name + "\n";
      constants += "layout(constant_id = " + std::to_string(k * kKernelEntries + entry) + ") const uint " + prefix +
                   "bucket = 0xffffffffu;\n";
      calls += "  if (megaBucket == " + prefix + "bucket) " + prefix + "main();\n";
    }
  }
  return text + includes + constants + bodies + "void megaMaterials() {\n" + calls + "}\n#include \"megakernel/tail.glsl\"\n";
}

}  // namespace materialgen
