// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// RenderDelegate: commit, the render in the background, images, statistics, colour.
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstring>

#include "delegate/colour/color_kernel.h"
#include "plugin/python/src/bindings.h"
#include "plugin/python/src/convert.h"
#include "plugin/python/src/images.h"

namespace nb = nanobind;
using namespace nb::literals;
using delegate::RenderDelegate;

template <typename T>
nb::object VectorToArray(std::vector<T> values, std::vector<size_t> shape);

namespace {

// Calls fn without the GIL and raises RuntimeError where the status it returns is bad.
template <typename Fn>
void Released(Fn fn) {
  const wavefront::Status status = [&] {
    nb::gil_scoped_release release;
    return fn();
  }();
  if (!status) RaiseRuntime(status.error().message);
}

size_t WriteCapture(const RenderDelegate& self, const std::string& path, const std::string& name, uint32_t maxTextureSide) {
  auto shrunk = [&] {
    nb::gil_scoped_release release;
    return self.WriteCapture(path, name, HDWAVEFRONT_VERSION, maxTextureSide);
  }();
  if (!shrunk) RaiseRuntime(shrunk.error().message);
  return shrunk.value();
}

bool Commit(RenderDelegate& self) {
  const uint64_t before = self.version();
  Released([&] { return self.CommitResources(); });
  return self.version() != before;
}

bool Wait(RenderDelegate& self, double timeout) {
  bool done = false;
  Released([&] {
    done = self.WaitUntilDone(timeout);
    return self.status();
  });
  return done;
}

nb::dict ProgressDict(const RenderDelegate& self) {
  const wavefront::Progress progress = self.progress();
  nb::dict d;
  d["pathsDone"] = progress.pathsDone;
  d["pathsTotal"] = progress.pathsTotal;
  d["samplesDone"] = progress.samplesDone;
  d["seconds"] = progress.seconds;
  d["running"] = progress.running;
  d["paused"] = progress.paused;
  d["converged"] = progress.converged;
  return d;
}

nb::object MapAov(RenderDelegate& self, const std::string& token) {
  const std::optional<wavefront::Aov> known = self.FindAov(token);
  if (!known) RaiseValue("the AOV \"" + token + "\" is not known, or is a primvar that was not asked for");
  const wavefront::Aov aov = *known;
  auto image = [&] {
    nb::gil_scoped_release release;
    return self.Map(aov);
  }();
  if (!image) RaiseRuntime(image.error().message);
  return ImageToArray(std::move(image).value());
}

wavefront::RawFilm ReadFilm(RenderDelegate& self) {
  auto film = [&] {
    nb::gil_scoped_release release;
    return self.ReadFilm();
  }();
  if (!film) RaiseRuntime(film.error().message);
  return std::move(film).value();
}

nb::dict CountersDict(const RenderDelegate& self) {
  const delegate::DelegateCounters c = self.counters();
  nb::dict d;
  d["meshesBuilt"] = c.meshesBuilt;
  d["meshesUploaded"] = c.meshesUploaded;
  d["instancesUploaded"] = c.instancesUploaded;
  d["lightsUploaded"] = c.lightsUploaded;
  d["camerasUploaded"] = c.camerasUploaded;
  d["materialsGenerated"] = c.materialsGenerated;
  d["materialsUploaded"] = c.materialsUploaded;
  d["kernelsCompiled"] = c.kernelsCompiled;
  d["imagesDecoded"] = c.imagesDecoded;
  d["texturesUploaded"] = c.texturesUploaded;
  d["commits"] = c.commits;
  return d;
}

nb::list KernelSources(const RenderDelegate& self) {
  nb::list list;
  for (const RenderDelegate::KernelUse& use : self.kernelUses()) {
    nb::dict d;
    d["key"] = use.key;
    d["lobes"] = use.lobes;
    d["primvars"] = use.primvars;
    d["materials"] = use.materials;
    d["generateMilliseconds"] = use.generateMilliseconds;
    d["state"] = use.state;
    d["codeMilliseconds"] = use.codeMilliseconds;
    d["codeFromCache"] = use.codeFromCache;
    d["createMilliseconds"] = use.createMilliseconds;
    d["firstDispatchMilliseconds"] = use.firstDispatchMilliseconds;
    d["spirvBytes"] = use.spirvBytes;
    d["spirvInstructions"] = use.spirvInstructions;
    d["driverStatistics"] = use.driverStatistics;
    d["milliseconds"] = use.milliseconds;
    d["paths"] = use.paths;
    d["nanosecondsPerPath"] = use.nanosecondsPerPath;
    d["share"] = use.share;
    list.append(d);
  }
  return list;
}

nb::dict StatsDict(const RenderDelegate& self) {
  const wavefront::RenderStats stats = [&] {
    nb::gil_scoped_release release;
    return self.stats();
  }();
  nb::dict d;
  nb::list kernels, queues;
  for (const wavefront::KernelStats& kernel : stats.kernels) {
    nb::dict k;
    k["name"] = kernel.name;
    k["milliseconds"] = kernel.milliseconds;
    k["items"] = kernel.items;
    k["peak"] = kernel.peak;
    k["occupancy"] = kernel.occupancy;
    k["dispatches"] = kernel.dispatches;
    k["state"] = kernel.state;
    k["codeMilliseconds"] = kernel.codeMilliseconds;
    k["codeFromCache"] = kernel.codeFromCache;
    k["spirvBytes"] = kernel.spirvBytes;
    k["spirvInstructions"] = kernel.spirvInstructions;
    k["stateBytesRead"] = kernel.stateBytesRead;
    k["stateBytesWritten"] = kernel.stateBytesWritten;
    k["createMilliseconds"] = kernel.createMilliseconds;
    k["firstDispatchMilliseconds"] = kernel.firstDispatchMilliseconds;
    kernels.append(k);
  }
  for (const wavefront::QueueStats& queue : stats.queues) {
    nb::dict q;
    q["name"] = queue.name;
    q["items"] = queue.items;
    q["peak"] = queue.peak;
    q["occupancy"] = queue.occupancy;
    q["milliseconds"] = queue.milliseconds;
    queues.append(q);
  }
  d["kernels"] = kernels;
  d["queues"] = queues;
  d["paths"] = stats.paths;
  d["segments"] = stats.segments;
  d["extensionRays"] = stats.extensionRays;
  d["shadowRays"] = stats.shadowRays;
  d["iterations"] = stats.iterations;
  d["submits"] = stats.submits;
  d["renderSeconds"] = stats.renderSeconds;
  d["commitSeconds"] = stats.commitSeconds;
  d["bvhSeconds"] = stats.bvhSeconds;
  d["memoryBytes"] = stats.memoryBytes;
  d["memoryPeakBytes"] = stats.memoryPeakBytes;
  nb::dict trees;
  trees["built"] = stats.trees.built;
  trees["builtFast"] = stats.trees.builtFast;
  trees["refitted"] = stats.trees.refitted;
  trees["instancesBuilt"] = stats.trees.instancesBuilt;
  trees["instancesRefitted"] = stats.trees.instancesRefitted;
  d["trees"] = trees;
  d["triangles"] = stats.triangles;
  d["instances"] = stats.instances;
  d["lights"] = stats.lights;
  d["lightItems"] = stats.lightItems;
  d["materials"] = stats.materials;
  d["textures"] = stats.textures;
  d["uploadedBytes"] = stats.uploadedBytes;
  d["validationMessages"] = stats.validationMessages;
  d["errorFlags"] = stats.errorFlags;
  d["poolSize"] = stats.poolSize;
  d["kernelsPending"] = stats.kernelsPending;
  d["firstPathSeconds"] = stats.firstPathSeconds;
  d["kernelsReadySeconds"] = stats.kernelsReadySeconds;
  d["executionMode"] = stats.executionMode == wavefront::ExecutionMode::Megakernel ? "megakernel" : "wavefront";
  d["counters"] = CountersDict(self);
  d["kernelSources"] = KernelSources(self);
  return d;
}

nb::object MatrixToArray(const wavefront::Matrix4d& matrix) {
  std::vector<double> values;
  for (const auto& row : matrix.m) values.insert(values.end(), row.begin(), row.end());
  return VectorToArray(std::move(values), {4, 4});
}

nb::tuple Matrices(const RenderDelegate& self) {
  const delegate::CameraMatrices matrices = self.cameraMatrices();
  return nb::make_tuple(MatrixToArray(matrices.worldToCamera), MatrixToArray(matrices.worldToNdc));
}

wavefront::Renderer::ColorLut ReadLut(nb::handle value) {
  wavefront::Renderer::ColorLut lut;
  const auto whole = [](nb::handle item, const std::string& name) {
    const double number = ReadNumber(item, name);
    if (!(number >= 1 && number <= 65536)) RaiseValue(name + " must be from 1 to 65536");
    return static_cast<uint32_t>(number);
  };
  ForItems(value, "lut", [&](const std::string& key, nb::handle item) {
    const std::string name = "lut's " + key;
    if (key == "sampler") lut.sampler = ReadString(item, name);
    else if (key == "dimension") lut.dimension = whole(item, name);
    else if (key == "width") lut.width = whole(item, name);
    else if (key == "height") lut.height = whole(item, name);
    else if (key == "depth") lut.depth = whole(item, name);
    else if (key == "components") lut.components = whole(item, name);
    else if (key == "linear") lut.linear = ReadBool(item, name);
    else if (key == "values") lut.values = ReadNumbers<float>(item, name).values;
    else RaiseValue("a lut has no \"" + key + "\"");
  });
  return lut;
}

nb::object RunColorKernel(RenderDelegate& self, nb::object pixels, std::string glsl, std::string function,
                          nb::object luts) {
  Numbers<float> numbers = ReadNumbers<float>(pixels, "pixels");
  if (numbers.shape.size() != 3 || numbers.shape[2] != 4 || numbers.values.empty())
    RaiseValue("pixels must have the shape (height, width, 4)");
  delegate::ColorShader shader;
  shader.glsl = std::move(glsl);
  shader.function = std::move(function);
  for (nb::handle lut : luts) shader.luts.push_back(ReadLut(lut));
  Released([&] {
    return delegate::RunColorShader(self.renderer(), shader, numbers.values, static_cast<uint32_t>(numbers.shape[1]),
                                    static_cast<uint32_t>(numbers.shape[0]));
  });
  return VectorToArray(std::move(numbers.values), numbers.shape);
}

nb::dict MaterialSource(const RenderDelegate& self, const std::string& path) {
  nb::dict d;
  for (const auto& [entry, source] : self.MaterialSource(path)) d[entry.c_str()] = source;
  return d;
}

nb::object ValueObject(const materialgen::Value& value) {
  return std::visit(
      [](const auto& held) -> nb::object {
        using Held = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<Held, std::monostate>) {
          return nb::none();
        } else if constexpr (std::is_same_v<Held, materialgen::AssetValue>) {
          nb::dict d;
          d["authoredPath"] = held.authoredPath;
          d["resolvedPath"] = held.resolvedPath;
          d["colorSpace"] = held.colorSpace;
          return d;
        } else if constexpr (std::is_arithmetic_v<Held> || std::is_same_v<Held, std::string>) {
          return nb::cast(held);
        } else {
          return nb::cast(std::vector<float>(held.begin(), held.end()));
        }
      },
      value);
}

nb::dict ExplainMaterial(const RenderDelegate& self, const std::string& path) {
  const auto facts = self.ExplainMaterial(path);
  if (!facts) RaiseValue("there is no material " + path + ", or it shows the default");
  nb::list nodes, connections, parameters;
  for (const materialgen::Node& node : facts->network.nodes) {
    nb::dict values, d;
    for (const auto& [name, value] : node.parameters) values[name.c_str()] = ValueObject(value);
    d["path"] = node.path;
    d["identifier"] = node.identifier;
    d["parameters"] = values;
    nodes.append(d);
  }
  for (const materialgen::Connection& connection : facts->network.connections) {
    nb::dict d;
    d["upstreamNode"] = connection.upstreamNode;
    d["upstreamOutput"] = connection.upstreamOutput;
    d["downstreamNode"] = connection.downstreamNode;
    d["downstreamInput"] = connection.downstreamInput;
    connections.append(d);
  }
  for (const auto& parameter : facts->parameters) {
    nb::dict d;
    d["node"] = parameter.node;
    d["input"] = parameter.input;
    d["values"] = parameter.values;
    parameters.append(d);
  }
  nb::dict d;
  d["context"] = facts->context;
  d["nodes"] = nodes;
  d["connections"] = connections;
  d["closureTree"] = facts->closureTree;
  d["parameters"] = parameters;
  return d;
}

}  // namespace

void BindRender(DelegateClass& type) {
  const auto released = nb::call_guard<nb::gil_scoped_release>();
  type.def("write_capture", &WriteCapture, "path"_a, "name"_a, "max_texture_side"_a = 0);
  type.def("commit", &Commit);
  type.def("start", [](RenderDelegate& self) { Released([&] { return self.Start(); }); });
  type.def("pause", &RenderDelegate::Pause, released);
  type.def("resume", &RenderDelegate::Resume, released);
  type.def("stop", &RenderDelegate::Stop, released);
  type.def("wait", &Wait, "timeout"_a = 1e9);
  type.def("progress", &ProgressDict);
  type.def("is_converged", &RenderDelegate::IsConverged, released);
  type.def("version", &RenderDelegate::version);
  type.def("map", &MapAov, "aov"_a);
  type.def("read_film", &ReadFilm);
  type.def("stats", &StatsDict);
  type.def("counters", &CountersDict);
  type.def("camera_matrices", &Matrices);
  type.def("explain_material", &ExplainMaterial, "path"_a);
  type.def("material_source", &MaterialSource, "path"_a);
  type.def("run_color_kernel", &RunColorKernel, "pixels"_a, nb::kw_only(), "glsl"_a, "function"_a,
           "luts"_a = nb::tuple());
}
