// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/convert_image.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec4f.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "plugin/hydra/convert_value.h"

namespace hydra {
namespace {

HdFormat ToFormat(const wavefront::AovInfo& info) {
  const bool isInt = info.format == wavefront::AovFormat::Int32;
  switch (info.components) {
    case 1: return isInt ? HdFormatInt32 : HdFormatFloat32;
    case 2: return isInt ? HdFormatInt32Vec2 : HdFormatFloat32Vec2;
    case 3: return isInt ? HdFormatInt32Vec3 : HdFormatFloat32Vec3;
    case 4: return isInt ? HdFormatInt32Vec4 : HdFormatFloat32Vec4;
    default: return HdFormatInvalid;
  }
}

template <typename T>
void Put(uint8_t* at, size_t channel, T value) {
  std::memcpy(at + channel * sizeof(T), &value, sizeof(T));
}

// Floats to the component type of a buffer.
void PutFloat(HdFormat component, uint8_t* at, size_t channel, float value) {
  const auto normalized = [&](float scale, float low) {
    return std::isnan(value) ? 0.0f : std::round(std::clamp(value, low, 1.0f) * scale);
  };
  switch (component) {
    case HdFormatFloat32: Put(at, channel, value); break;
    case HdFormatFloat16: Put(at, channel, GfHalf(value).bits()); break;
    case HdFormatInt32: Put(at, channel, static_cast<int32_t>(value)); break;
    case HdFormatUNorm8: Put(at, channel, static_cast<uint8_t>(normalized(255, 0))); break;
    case HdFormatSNorm8: Put(at, channel, static_cast<int8_t>(normalized(127, -1))); break;
    case HdFormatUInt16: Put(at, channel, static_cast<uint16_t>(std::max(value, 0.0f))); break;
    case HdFormatInt16: Put(at, channel, static_cast<int16_t>(value)); break;
    default: break;
  }
}

void PutInt(HdFormat component, uint8_t* at, size_t channel, int32_t value) {
  switch (component) {
    case HdFormatInt32: Put(at, channel, value); break;
    case HdFormatUNorm8: Put(at, channel, static_cast<uint8_t>(value)); break;  // ids as bytes, as pickers read them
    case HdFormatUInt16: Put(at, channel, static_cast<uint16_t>(value)); break;
    case HdFormatInt16: Put(at, channel, static_cast<int16_t>(value)); break;
    default: PutFloat(component, at, channel, static_cast<float>(value)); break;
  }
}

VtValue ClearValue(const wavefront::AovInfo& info) {
  if (info.format == wavefront::AovFormat::Int32) return VtValue(static_cast<int>(info.clear));
  if (info.components == 4) return VtValue(GfVec4f(info.clear));
  if (info.components == 3) return VtValue(GfVec3f(info.clear));
  return VtValue(info.clear);
}

}  // namespace

HdAovDescriptor ToAovDescriptor(const TfToken& name) {
  const bool isPrimvar = HdParsedAovToken(name).isPrimvar;
  const wavefront::AovInfo* info = isPrimvar ? &wavefront::Aovs()[static_cast<size_t>(wavefront::Aov::Primvar0)]
                                             : wavefront::FindAov(name.GetString());
  if (!info) return {};
  return HdAovDescriptor(ToFormat(*info), /*multiSampled=*/false, ClearValue(*info));
}

std::vector<uint8_t> ClearedPixels(unsigned width, unsigned height, HdFormat format, const VtValue& clearValue) {
  const size_t size = HdDataSizeOfFormat(format), count = size_t{width} * height;
  std::vector<uint8_t> pixels(size * count, 0);
  const auto floats = ToFloats(clearValue);
  if (!floats || pixels.empty()) return pixels;
  const bool isInt = clearValue.IsHolding<int>();
  for (size_t c = 0; c < std::min<size_t>(HdGetComponentCount(format), floats->values.size()); ++c)
    if (isInt) PutInt(HdGetComponentFormat(format), pixels.data(), c, clearValue.UncheckedGet<int>());
    else PutFloat(HdGetComponentFormat(format), pixels.data(), c, floats->values[c]);
  for (size_t i = 1; i < count; ++i) std::memcpy(&pixels[i * size], pixels.data(), size);
  return pixels;
}

void CopyImage(const wavefront::AovImage& image, int x, int y, unsigned width, unsigned height, HdFormat format,
               std::vector<uint8_t>& pixels) {
  const size_t size = HdDataSizeOfFormat(format);
  if (pixels.size() != size * width * height || size == 0) return;
  const HdFormat component = HdGetComponentFormat(format);
  const size_t channels = std::min<size_t>(HdGetComponentCount(format), image.components);
  const bool isInt = wavefront::Aovs()[static_cast<size_t>(image.aov)].format == wavefront::AovFormat::Int32;
  for (uint32_t row = 0; row < image.height; ++row) {
    const int64_t fromTop = int64_t{row} + y;
    if (fromTop < 0 || fromTop >= int64_t{height}) continue;
    const size_t target = size_t{height} - 1 - static_cast<size_t>(fromTop);
    for (uint32_t column = 0; column < image.width; ++column) {
      const int64_t at = int64_t{column} + x;
      if (at < 0 || at >= int64_t{width}) continue;
      uint8_t* pixel = &pixels[(target * width + static_cast<size_t>(at)) * size];
      const uint32_t* bits = &image.bits[(size_t{row} * image.width + column) * image.components];
      for (size_t c = 0; c < channels; ++c)
        if (isInt) PutInt(component, pixel, c, static_cast<int32_t>(bits[c]));
        else PutFloat(component, pixel, c, std::bit_cast<float>(bits[c]));
    }
  }
}

}  // namespace hydra
