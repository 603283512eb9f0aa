// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// MaterialX's data libraries, read once into plain structures: node definitions, their implementations, and the node
// graphs among them. The only place that knows MaterialX's C++.
#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "materialgen/materialgen.h"
#include "materialgen/type.h"

namespace materialgen {

struct Graph;

struct PortDefinition {
  std::string name;
  Type type = Type::None;
  std::string value;  // default as text; empty: none
  bool isColor = false;
  std::string geomprop;  // "Nworld", "UV0", ...: what an unconnected input without a value reads
};

struct NodeDefinition {
  enum class Implementation { None, Graph, Inline, Function };
  std::string name;      // "ND_add_float"
  std::string category;  // "add"
  std::vector<PortDefinition> inputs, outputs;
  Implementation implementation = Implementation::None;
  std::string source;            // Inline: expression with {{input}}; Function: the function's name
  std::string file;              // Function: where it is defined
  const Graph* graph = nullptr;  // Graph: filled by Library::GraphOf

  const PortDefinition* FindInput(std::string_view input) const;
  const PortDefinition* FindOutput(std::string_view output) const;
};

struct GraphInput {
  enum class Source { Value, Node, Interface };
  std::string name;
  Source source = Source::Value;
  std::string value;   // Value: text; Interface: name of the graph's input
  uint32_t node = 0;   // Node: index into Graph::nodes, smaller than the reader's own
  std::string output;  // Node
};

struct GraphNode {
  const NodeDefinition* definition = nullptr;
  std::string name;
  std::vector<GraphInput> inputs;
};

struct GraphOutput {
  std::string name;
  uint32_t node = 0;
  std::string output;
};

// A node graph of the library, nodes in topological order.
struct Graph {
  std::vector<GraphNode> nodes;
  std::vector<GraphOutput> outputs;
};

// Thread-safe.
class Library {
 public:
  static std::unique_ptr<Library> Load(const std::string& path, std::string* error);
  ~Library();

  // By nodedef name or USD id; null where unknown. Lives as long as the library.
  const NodeDefinition* Find(const std::string& identifier) const;
  // The graph that implements a definition of kind Graph; null where the library's graph is broken.
  const Graph* GraphOf(const NodeDefinition& definition);
  // The standard library's mathematics, which inline expressions and functions rely on.
  std::string MathFile() const;
  // Text of a library function's file with its includes resolved, each file once per `seen`. Empty: not readable.
  std::string FunctionSource(const std::string& file, std::set<std::string>* seen);

 private:
  struct Impl;
  explicit Library(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace materialgen
