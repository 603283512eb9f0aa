// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Computes the table of wavefront/shared/interface_table.h while the project is built: interface_table OUTPUT writes
// the body of an array of uint32_t. Quadrature over visible normals of a height-correlated Smith GGX interface.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <thread>
#include <vector>

#include "wavefront/shared/interface_table.h"

namespace {

using namespace wavefront::layout;

constexpr int kAzimuths = 48, kHeights = 96;

double Square(double x) { return x * x; }

// Unpolarised; eta = index beyond / index on this side.
double Fresnel(double cosine, double eta) {
  const double g2 = eta * eta - 1 + cosine * cosine;
  if (g2 <= 0) return 1;
  const double g = std::sqrt(g2);
  return 0.5 * (Square((cosine - g) / (cosine + g)) + Square((eta * eta * cosine - g) / (eta * eta * cosine + g)));
}

// Smith's Lambda of GGX (Heitz 2014, equation 72).
double Lambda(double z, double alpha) {
  z = std::max(z, 1e-7);
  return 0.5 * (std::sqrt(1 + alpha * alpha * std::max(1 - z * z, 0.0) / (z * z)) - 1);
}

struct Entry {
  double reflected = 0, share = 0;
};

// Visible normals by spherical caps (Dupuy and Benyoub 2023), half of the azimuths: the interface is isotropic.
Entry Measure(double mu, double alpha, double eta) {
  const double sine = std::sqrt(std::max(1 - mu * mu, 0.0)), outgoing = Lambda(mu, alpha);
  double wx = alpha * sine, wz = mu;
  const double length = std::hypot(wx, wz);
  wx /= length;
  wz /= length;
  double e = 0, f1 = 0, f2 = 0, transmitted = 0;
  for (int i = 0; i < kAzimuths; ++i) {
    const double phi = (i + 0.5) / kAzimuths * M_PI, cosPhi = std::cos(phi), sinPhi = std::sin(phi);
    for (int j = 0; j < kHeights; ++j) {
      const double z = (1 - (j + 0.5) / kHeights) * (1 + wz) - wz, r = std::sqrt(std::max(1 - z * z, 0.0));
      const double hx = alpha * (r * cosPhi + wx), hy = alpha * r * sinPhi, hz = z + wz;
      const double scale = 1 / std::sqrt(hx * hx + hy * hy + hz * hz);
      const double cosine = std::clamp((hx * sine + hz * mu) * scale, 0.0, 1.0), normal = hz * scale;
      const double f = Fresnel(cosine, eta);
      const double up = 2 * cosine * normal - mu;
      if (up > 0) {
        const double mask = (1 + outgoing) / (1 + outgoing + Lambda(up, alpha));
        e += mask;
        f1 += mask * f;
        f2 += mask * f * f;
      }
      const double g2 = cosine * cosine + eta * eta - 1;
      if (g2 <= 0) continue;
      const double down = ((cosine - std::sqrt(g2)) * normal - mu) / eta;
      if (down < 0) transmitted += (1 - f) * (1 + outgoing) / (1 + outgoing + Lambda(-down, alpha));
    }
  }
  const double count = double(kAzimuths) * kHeights, albedo = e / count;
  Entry entry;
  entry.reflected = (f1 + f2 * (1 - albedo) / albedo) / count;
  // Where nearly everything reflects, the ratio says little and its neighbours interpolate it: towards 1 there.
  entry.share = (transmitted / count + 1e-3) / (1 - entry.reflected + 1e-3);
  return entry;
}

double IndexAt(uint32_t i) {
  const double x = kInterfaceMinRoot + (kInterfaceMaxRoot - kInterfaceMinRoot) * i / (kInterfaceIndices - 1.0);
  return (1 + x * x) / (1 - x * x);
}

double AlphaAt(uint32_t i) {
  const double low = std::sqrt(kInterfaceMinAlpha);
  return std::max(Square(low + (1 - low) * i / (kInterfaceAlphas - 1.0)), double(kInterfaceMinAlpha));
}

// Inverse of the warps of lib/bsdf/interface_table.glsl.
double CosineAt(uint32_t i, uint32_t side, double n) {
  const double p = i / (kInterfaceCosines - 1.0);
  if (side == 0) {
    const double k = interfaceScale(float(n));
    return std::clamp(k * p / (1 + k - p), 1e-3, 1.0);
  }
  const double critical = std::sqrt(1 - 1 / (n * n)), q = 2 * p - 1, s = std::pow(std::abs(q), 1.5);
  return std::clamp(q < 0 ? critical * (1 - s) : critical + (1 - critical) * s, 1e-3, 1.0);
}

uint32_t Pack(const Entry& entry) {
  const auto unorm = [](double x) { return uint32_t(std::lround(std::clamp(x, 0.0, 1.0) * 65535)); };
  return unorm(entry.reflected) | unorm(entry.share) << 16;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  constexpr uint32_t kRows = 2 * kInterfaceIndices * kInterfaceAlphas;
  std::vector<uint32_t> packed(kInterfaceEntries);
  const auto fill = [&](uint32_t first, uint32_t step) {
    for (uint32_t row = first; row < kRows; row += step) {
      const uint32_t side = row / (kInterfaceIndices * kInterfaceAlphas);
      const double n = IndexAt(row / kInterfaceAlphas % kInterfaceIndices), alpha = AlphaAt(row % kInterfaceAlphas);
      for (uint32_t i = 0; i < kInterfaceCosines; ++i) {
        packed[row * kInterfaceCosines + i] = Pack(Measure(CosineAt(i, side, n), alpha, side == 0 ? n : 1 / n));
      }
    }
  };
  const uint32_t threads = std::max(std::thread::hardware_concurrency(), 1u);
  std::vector<std::thread> pool;
  for (uint32_t t = 0; t < threads; ++t) pool.emplace_back(fill, t, threads);
  for (std::thread& thread : pool) thread.join();
  std::FILE* out = std::fopen(argv[1], "w");
  if (!out) return 1;
  for (size_t i = 0; i < packed.size(); ++i) std::fprintf(out, "0x%08xu,%s", packed[i], i % 8 == 7 ? "\n" : " ");
  return std::fclose(out) == 0 ? 0 : 1;
}
