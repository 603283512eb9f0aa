// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pattern nodes that read textures, or ask how something changes over the surface.
#include <string>
#include <string_view>
#include <vector>

#include "materialgen/builder.h"

namespace materialgen {
namespace {

// Heights are computed three times, and heights of heights nine times: enough for what artists make, not for a flood.
constexpr size_t kMaximumBeforeMoving = 4000;

// Whether the host will hand over a set of tiles: it goes by the path that it was given to load.
bool IsTilePattern(const AssetValue& file) {
  const std::string& path = file.resolvedPath.empty() ? file.authoredPath : file.resolvedPath;
  return path.find("<UDIM>") != std::string::npos || path.find("<UVTILE>") != std::string::npos;
}

}  // namespace

// Width of the ray cone in units of the texture coordinate `uv`, followed through what scales it.
Id NodeEvaluator::Footprint(Id uv, int depth) {
  const Expression expression = e_[uv];
  if (depth > 16 || expression.rate != Class::Varying) return kNone;
  const std::string_view op = expression.op->name;
  if (op == "uv_value") return e_.Make("footprint", Type::Float, {expression.arguments[0]});
  if (op == "position_world") return e_.Make("footprint_world", Type::Float, {});
  if (op == "position_object") return e_.Make("footprint_object", Type::Float, {});
  if (op == "tangent" || op == "bitangent") return kNone;
  for (size_t i = 0; i < expression.arguments.size(); ++i) {
    const Id footprint = Footprint(expression.arguments[i], depth + 1);
    if (footprint == kNone) continue;
    const Id other = expression.arguments.size() == 2 ? expression.arguments[1 - i] : kNone;
    const bool isScaled = (op == "multiply" || (op == "divide" && i == 0)) && e_.IsUniform(other);
    if (!isScaled) return footprint;
    const Id scale = op == "multiply" ? other : e_.Arithmetic("divide", {e_.Number(1), other});
    return e_.Arithmetic("multiply", {footprint, e_.Make("maximum_abs", Type::Float, {scale})});
  }
  return kNone;
}

// The texture coordinates ("uv") that feed a value: a normal map's tangents follow them. kNone: none.
Id NodeEvaluator::UvOf(Id id, int depth) {
  const Expression& expression = e_[id];
  if (depth > 16 || expression.rate != Class::Varying) return kNone;
  if (expression.op->name == "uv") return id;
  for (Id argument : expression.arguments) {
    const Id uv = UvOf(argument, depth + 1);
    if (uv != kNone) return uv;
  }
  return kNone;
}

Id NodeEvaluator::TextureOf(std::string_view input) {
  const AssetValue* asset = e_.AssetOf(In(input));
  if (!asset || (asset->authoredPath.empty() && asset->resolvedPath.empty())) return kNone;
  TextureLeaf texture;
  texture.node = b_.current_ ? b_.current_->path : b_.network_.path;
  texture.file = *asset;
  texture.isColor = node_.definition->name.find("color") != std::string::npos;
  const bool isUsd = b_.current_ && b_.current_->identifier == "UsdUVTexture";
  if (isUsd || node_.owner) {
    if (b_.current_) {
      const auto space = b_.current_->parameters.find("sourceColorSpace");
      const auto* text = space == b_.current_->parameters.end() ? nullptr : std::get_if<std::string>(&space->second);
      if (text) texture.sourceColorSpace = *text;
    }
    if (isUsd && texture.sourceColorSpace.empty()) texture.sourceColorSpace = "auto";
  }
  return e_.Texture(texture);
}

bool NodeEvaluator::EvaluateTexture(Port* result) {
  const std::string_view category = node_.definition->category;
  if (category == "image") return EvaluateImage(result);
  if (category == "hextiledimage" || category == "hextilednormalmap") return EvaluateHexTiles(result);
  if (category == "normalmap") return EvaluateNormalMap(result);
  if (category == "heighttonormal") return EvaluateHeightToNormal(result);
  if (category == "splitlr" || category == "splittb") return EvaluateSplit(result);
  return false;
}

// Says what of an image node counts and is not read: a layer of the file, and a sequence of files by frame
// (MaterialX 1.39, "Image nodes"). An offset or end action without either changes nothing.
void NodeEvaluator::SayLayersAndFrames(const AssetValue& file) {
  std::string layer, range;
  InText("layer", &layer);
  InText("framerange", &range);
  if (!layer.empty()) Unsupported("'layer' of an image node is not read: not '" + layer + "' but the file's first is shown");
  if (!range.empty() || file.authoredPath.find("frame}") != std::string::npos)
    Unsupported("image sequences ('framerange', 'frameoffset', 'frameendaction', {frame} in a file's name) are not read; "
                "the file is shown at every frame");
}

bool NodeEvaluator::EvaluateImage(Port* result) {
  const Type type = OutputType();
  const Id fallback = In("default", type), uv = In("texcoord", Type::Vec2);
  if (fallback == kNone || uv == kNone || In("file") == kNone) return false;
  const Id texture = TextureOf("file");
  if (texture == kNone) return Number(result, fallback);
  SayLayersAndFrames(*e_.AssetOf(In("file")));
  const bool isUsd = b_.current_ && b_.current_->identifier == "UsdUVTexture";
  Id footprint = Footprint(uv);
  if (footprint == kNone) footprint = e_.Number(0);
  const Id whole = e_.Convert(fallback, Type::Vec4);
  std::string filter = "linear";
  InText("filtertype", &filter);
  filter = filter == "closest" ? "Closest" : filter == "cubic" ? "Cubic" : "";
  if (IsTilePattern(*e_.AssetOf(In("file"))))
    return Number(result, e_.Make("image_tiles", Type::Vec4, {texture, uv, footprint, whole}, filter));
  // Numbers of WrapMode in wavefront/scene.h.
  bool isConstant = false;
  const auto wrap = [&](std::string_view input, const char* usd) {
    std::string mode = "periodic";
    InText(input, &mode);
    // USD's default is "useMetadata": what the file says. Image files in use say nothing, USD's text leaves that case
    // open, and assets rely on what MaterialX's definition of the node and production renderers do: repeat.
    if (isUsd && !b_.current_->parameters.count(usd)) mode = "useMetadata";
    if (mode == "clamp") return "1u";
    if (mode == "mirror") return "2u";
    isConstant = isConstant || mode == "constant";
    return mode == "black" || mode == "constant" ? "3u" : "0u";
  };
  const std::string modes = std::string(wrap("uaddressmode", "wrapS")) + ", " + wrap("vaddressmode", "wrapT");
  const Id outside = isConstant ? whole : e_.Literal(Type::Vec4, {});
  const Id texel = e_.Make("image", Type::Vec4, {texture, uv, footprint, outside, whole}, filter + "(" + modes);
  return Number(result, texel);
}

// Mikkelsen, "Practical Real-Time Hex-Tiling" (2022), with the inputs that MaterialX gives it.
bool NodeEvaluator::EvaluateHexTiles(Port* result) {
  const bool isNormal = node_.definition->category == "hextilednormalmap";
  const Type type = OutputType();
  const Id fallback = In("default", type);
  Id texture = TextureOf("file");
  if (fallback == kNone) return false;
  if (texture != kNone && IsTilePattern(*e_.AssetOf(In("file")))) {
    Unsupported("'" + node_.definition->name + "': UDIM tiles cannot be hex-tiled; the default is used");
    texture = kNone;
  }
  const Id uv = e_.Arithmetic("multiply", {In("texcoord"), In("tiling")});
  Id footprint = Footprint(uv);
  if (footprint == kNone) footprint = e_.Number(0);
  const auto pack = [&](Type packed, std::vector<Id> parts) { return e_.Make("construct", packed, std::move(parts)); };
  const Id amounts = pack(Type::Vec4, {In("rotation"), In("scale"), In("offset"), In("falloff")});
  const Id ranges = pack(Type::Vec4, {In("rotationrange"), In("scalerange")});
  if (!isNormal) {
    if (texture == kNone) return Number(result, fallback);
    const Id luminance = pack(Type::Vec4, {In("lumacoeffs"), In("falloffcontrast")});
    const Id whole = e_.Convert(fallback, Type::Vec4);
    return Number(result, e_.Make("hextiles", Type::Vec4, {texture, uv, footprint, amounts, ranges, In("offsetrange"),
                                                           luminance, whole}));
  }
  if (texture == kNone) return Number(result, In("normal"));
  const Id coordinates = UvOf(uv), normal = In("normal"), flip = In("flip_g", Type::Float);
  const Id strength = pack(Type::Vec4, {In("strength"), flip, In("offsetrange")});
  const Id t = TangentFor("tangent", coordinates), b = TangentFor("bitangent", coordinates);
  return Number(result, e_.Make("hextiled_normal", Type::Vec3, {texture, uv, footprint, amounts, ranges, strength,
                                                                e_.Convert(fallback, Type::Vec3), normal, t, b}));
}

Id NodeEvaluator::TangentFor(std::string_view name, Id uv) {
  const Id given = In(name, Type::Vec3);
  const bool isDefault = given == kNone || e_[given].op->name == name;
  if (!isDefault) return given;
  if (uv == kNone) return b_.TextureCoordinates(name, "st", e_.Literal(Type::Vec2, {}));
  return e_.Make(name, Type::Vec3, {e_.Make("uv_frame", Type::Frame, {uv})});
}

bool NodeEvaluator::EvaluateNormalMap(Port* result) {
  const Id in = In("in", Type::Vec3), normal = In("normal", Type::Vec3), scale = In("scale", Type::Vec2);
  if (in == kNone || normal == kNone || scale == kNone) return false;
  const Id direction = e_.Arithmetic("subtract", {e_.Arithmetic("multiply", {in, e_.Number(2)}), e_.Number(1)});
  // A straight normal, however it is spelled, is no normal map at all.
  if (e_.IsLiteral(direction)) {
    const Constant& d = e_[direction].value;
    if (d[0] == 0 && d[1] == 0 && d[2] > 0) return Number(result, normal);
  }
  const Id uv = UvOf(in), t = TangentFor("tangent", uv), b = TangentFor("bitangent", uv);
  return Number(result, e_.Make("normalmap", Type::Vec3, {direction, scale, normal, t, b}));
}

// A compute kernel has no neighbours to take derivatives from: what feeds the heights is computed at two more places.
Id NodeEvaluator::Moved(Id root, int edge) {
  std::vector<bool> reached(root + 1, false);
  reached[root] = true;
  for (Id id = root + 1; id-- > 0;) {
    if (!reached[id] || e_[id].rate != Class::Varying) continue;
    for (Id argument : e_[id].arguments) reached[argument] = true;
  }
  std::vector<Id> moved(root + 1, kNone);
  for (Id id = 0; id <= root; ++id) {
    moved[id] = id;
    if (!reached[id] || e_[id].rate != Class::Varying) continue;
    const Expression expression = e_[id];  // a copy: making expressions moves them
    const std::string_view op = expression.op->name;
    const std::string number = std::to_string(edge);
    if (op == "uv_value") {
      moved[id] = e_.Make("uv_moved", expression.type, {expression.arguments[0]}, number);
    } else if (op == "position_world" || op == "position_object") {
      moved[id] = e_.Make(std::string(op) + "_moved", expression.type, {}, number);
    } else if (op == "primvar") {
      moved[id] = e_.Make("primvar_moved" + number, expression.type, expression.arguments, expression.text);
    } else if (op != "uv" && op != "uv_frame" && op != "footprint") {
      std::vector<Id> arguments = expression.arguments;
      for (Id& argument : arguments) argument = moved[argument];
      if (arguments != expression.arguments)
        moved[id] = e_.Make(*expression.op, expression.type, std::move(arguments), expression.text);
    }
  }
  return moved[root];
}

bool NodeEvaluator::EvaluateHeightToNormal(Port* result) {
  const Id height = In("in", Type::Float), scale = In("scale", Type::Float), uv = In("texcoord", Type::Vec2);
  if (height == kNone || scale == kNone || uv == kNone) return false;
  if (e_.IsUniform(height)) return Number(result, e_.Literal(Type::Vec3, {0.5f, 0.5f, 1}));
  if (e_.size() > kMaximumBeforeMoving) {
    Unsupported("the heights of '" + node_.definition->name + "' come from too large a network; the surface stays flat");
    return Number(result, e_.Literal(Type::Vec3, {0.5f, 0.5f, 1}));
  }
  std::vector<Id> arguments;
  for (Id of : {height, uv}) {
    arguments.push_back(of);
    for (int edge : {1, 2}) arguments.push_back(Moved(of, edge));
  }
  arguments.push_back(scale);
  return Number(result, e_.Make("height_to_normal", Type::Vec3, std::move(arguments)));
}

// A step, as soft as the ray cone is wide.
bool NodeEvaluator::EvaluateSplit(Port* result) {
  const bool isHorizontal = node_.definition->category == "splitlr";
  const Id uv = In("texcoord", Type::Vec2), center = In("center", Type::Float);
  if (uv == kNone || center == kNone) return false;
  const Id at = e_.Make("swizzle", Type::Float, {uv}, isHorizontal ? "x" : "y");
  Id width = Footprint(uv);
  if (width == kNone) width = e_.Number(0);
  const Id side = e_.Make("soft_step", Type::Float, {center, at, width});
  const Id low = In(isHorizontal ? "valuel" : "valueb"), high = In(isHorizontal ? "valuer" : "valuet");
  return Number(result, e_.Arithmetic("mix", {low, high, side}));
}

}  // namespace materialgen
