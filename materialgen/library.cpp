// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/library.h"

#include <MaterialXCore/Document.h>
#include <MaterialXFormat/Util.h>

#include <filesystem>
#include <sstream>

namespace mx = MaterialX;

namespace materialgen {
namespace {

const char* const kTarget = "genglsl";

// USD's own shader ids, which are not nodedef names.
const std::unordered_map<std::string, std::string>& UsdIdentifiers() {
  static const auto* map = new std::unordered_map<std::string, std::string>{
      {"UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader"},
      {"UsdUVTexture", "ND_UsdUVTexture"},
      {"UsdTransform2d", "ND_UsdTransform2d"},
      {"UsdPrimvarReader_int", "ND_UsdPrimvarReader_integer"},
      {"UsdPrimvarReader_string", "ND_UsdPrimvarReader_string"},
      {"UsdPrimvarReader_float", "ND_UsdPrimvarReader_float"},
      {"UsdPrimvarReader_float2", "ND_UsdPrimvarReader_vector2"},
      {"UsdPrimvarReader_float3", "ND_UsdPrimvarReader_vector3"},
      {"UsdPrimvarReader_float4", "ND_UsdPrimvarReader_vector4"},
      {"UsdPrimvarReader_point", "ND_UsdPrimvarReader_vector3"},
      {"UsdPrimvarReader_normal", "ND_UsdPrimvarReader_vector3"},
      {"UsdPrimvarReader_vector", "ND_UsdPrimvarReader_vector3"},
  };
  return *map;
}

// One spelling per file, so that each is included once.
std::string Normalised(const std::string& path) {
  return std::filesystem::path(path).lexically_normal().string();
}

}  // namespace

const PortDefinition* NodeDefinition::FindInput(std::string_view input) const {
  for (const PortDefinition& port : inputs) {
    if (port.name == input) return &port;
  }
  return nullptr;
}

const PortDefinition* NodeDefinition::FindOutput(std::string_view output) const {
  for (const PortDefinition& port : outputs) {
    if (port.name == output) return &port;
  }
  return nullptr;
}

struct Library::Impl {
  std::string path;
  mx::DocumentPtr document;
  std::unordered_map<std::string, std::unique_ptr<NodeDefinition>> definitions;
  std::mutex mutex;  // guards what follows
  std::unordered_map<std::string, std::unique_ptr<Graph>> graphs;
  std::unordered_map<std::string, std::string> files;

  void Add(const mx::NodeDefPtr& source);
  std::unique_ptr<Graph> Read(const NodeDefinition& definition) const;
  const std::string& ReadFile(const std::string& relativePath);
};

void Library::Impl::Add(const mx::NodeDefPtr& source) {
  auto definition = std::make_unique<NodeDefinition>();
  definition->name = source->getName();
  definition->category = source->getNodeString();
  for (const mx::InputPtr& input : source->getActiveInputs()) {
    PortDefinition port;
    port.name = input->getName();
    port.type = TypeFromMaterialX(input->getType());
    port.isColor = input->getType().rfind("color", 0) == 0;
    port.value = input->getValueString();
    port.geomprop = input->getDefaultGeomPropString();
    definition->inputs.push_back(std::move(port));
  }
  // The order in which a library function takes its outputs.
  for (const mx::OutputPtr& output : source->getActiveOutputs()) {
    PortDefinition port;
    port.name = output->getName();
    port.type = TypeFromMaterialX(output->getType());
    definition->outputs.push_back(std::move(port));
  }
  const mx::InterfaceElementPtr implementation = source->getImplementation(kTarget);
  if (implementation && implementation->isA<mx::NodeGraph>()) {
    definition->implementation = NodeDefinition::Implementation::Graph;
  } else if (implementation && implementation->isA<mx::Implementation>()) {
    const auto code = implementation->asA<mx::Implementation>();
    if (code->hasAttribute("sourcecode")) {
      definition->implementation = NodeDefinition::Implementation::Inline;
      definition->source = code->getAttribute("sourcecode");
      // A few rows of the library end in a stray semicolon.
      while (!definition->source.empty() && (definition->source.back() == ';' || definition->source.back() == ' ')) {
        definition->source.pop_back();
      }
    } else if (!code->getFile().empty()) {
      definition->implementation = NodeDefinition::Implementation::Function;
      definition->source = code->getFunction();
      // Relative to the library file that names it.
      definition->file =
          Normalised((mx::FilePath(code->getActiveSourceUri()).getParentPath() / code->getFile()).asString());
    }
  }
  definitions.emplace(definition->name, std::move(definition));
}

std::unique_ptr<Graph> Library::Impl::Read(const NodeDefinition& definition) const {
  const mx::NodeDefPtr source = document->getNodeDef(definition.name);
  const mx::InterfaceElementPtr implementation = source ? source->getImplementation(kTarget) : nullptr;
  const auto graph = implementation ? implementation->asA<mx::NodeGraph>() : nullptr;
  if (!graph) return nullptr;
  auto result = std::make_unique<Graph>();
  std::unordered_map<std::string, uint32_t> indices;
  // Library graphs are small and shallow; the depth bound keeps a broken one from recursing for ever.
  const auto visit = [&](const auto& self, const std::string& name, int depth) -> bool {
    if (indices.count(name)) return true;
    const mx::NodePtr node = graph->getNode(name);
    if (!node || depth > 256) return false;
    GraphNode entry;
    entry.name = name;
    const mx::NodeDefPtr nodeDefinition = node->getNodeDef(kTarget);
    if (nodeDefinition) {
      const auto found = definitions.find(nodeDefinition->getName());
      if (found != definitions.end()) entry.definition = found->second.get();
    }
    if (!entry.definition) return false;
    for (const mx::InputPtr& input : node->getInputs()) {
      GraphInput port;
      port.name = input->getName();
      if (input->hasNodeName()) {
        if (!self(self, input->getNodeName(), depth + 1)) return false;
        port.source = GraphInput::Source::Node;
        port.node = indices.at(input->getNodeName());
        port.output = input->getOutputString();
      } else if (input->hasInterfaceName()) {
        port.source = GraphInput::Source::Interface;
        port.value = input->getInterfaceName();
      } else if (input->hasOutputString()) {
        return false;
      } else {
        port.value = input->getValueString();
      }
      entry.inputs.push_back(std::move(port));
    }
    indices.emplace(name, uint32_t(result->nodes.size()));
    result->nodes.push_back(std::move(entry));
    return true;
  };
  for (const mx::OutputPtr& output : graph->getOutputs()) {
    if (!visit(visit, output->getNodeName(), 0)) return nullptr;
    result->outputs.push_back({output->getName(), indices.at(output->getNodeName()), output->getOutputString()});
  }
  return result;
}

const std::string& Library::Impl::ReadFile(const std::string& relativePath) {
  const auto found = files.find(relativePath);
  if (found != files.end()) return found->second;
  return files.emplace(relativePath, mx::readFile(mx::FilePath(relativePath))).first->second;
}

Library::Library(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Library::~Library() = default;

std::unique_ptr<Library> Library::Load(const std::string& path, std::string* error) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->document = mx::createDocument();
  try {
    mx::FilePathVec folders;
    for (const char* folder : {"targets", "stdlib", "pbrlib", "bxdf", "cmlib", "nprlib"}) folders.emplace_back(folder);
    mx::loadLibraries(folders, mx::FileSearchPath(path), impl->document);
    for (const mx::NodeDefPtr& definition : impl->document->getNodeDefs()) impl->Add(definition);
  } catch (const std::exception& exception) {
    *error = exception.what();
    return nullptr;
  }
  if (!impl->definitions.count("ND_UsdPreviewSurface_surfaceshader")) {
    *error = "no MaterialX libraries (stdlib, pbrlib, bxdf) in '" + path + "'";
    return nullptr;
  }
  return std::unique_ptr<Library>(new Library(std::move(impl)));
}

const NodeDefinition* Library::Find(const std::string& identifier) const {
  const auto usd = UsdIdentifiers().find(identifier);
  const auto found = impl_->definitions.find(usd == UsdIdentifiers().end() ? identifier : usd->second);
  return found == impl_->definitions.end() ? nullptr : found->second.get();
}

const Graph* Library::GraphOf(const NodeDefinition& definition) {
  const std::lock_guard lock(impl_->mutex);
  const auto found = impl_->graphs.find(definition.name);
  if (found != impl_->graphs.end()) return found->second.get();
  return impl_->graphs.emplace(definition.name, impl_->Read(definition)).first->second.get();
}

std::string Library::MathFile() const {
  return Normalised(impl_->path + "/stdlib/genglsl/lib/mx_math.glsl");
}

std::string Library::FunctionSource(const std::string& file, std::set<std::string>* seen) {
  const std::lock_guard lock(impl_->mutex);
  const auto append = [&](const auto& self, const std::string& path, std::string* out) -> void {
    if (!seen->insert(path).second) return;
    const std::string folder = path.substr(0, path.find_last_of('/') + 1);
    std::istringstream lines(impl_->ReadFile(path));
    for (std::string line; std::getline(lines, line);) {
      const size_t begin = line.find('"');
      if (line.rfind("#include", 0) == 0 && begin != std::string::npos) {
        const std::string name = line.substr(begin + 1, line.find('"', begin + 1) - begin - 1);
        // Includes are relative to the file, or to the target's folder of the standard library.
        const std::string beside = Normalised(folder + name);
        const std::string standard = Normalised(impl_->path + "/stdlib/genglsl/" + name);
        self(self, !impl_->ReadFile(beside).empty() ? beside : standard, out);
      } else {
        out->append(line).push_back('\n');
      }
    }
  };
  std::string result;
  append(append, file, &result);
  return result;
}

}  // namespace materialgen
