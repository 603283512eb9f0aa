// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Documents and nodes of MaterialX, all that there are: they compile.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <set>

#include "tests/materialgen/fixture.h"
#include "tests/materialgen/mtlx_network.h"

namespace materialgen {
namespace {

std::filesystem::path Assets() {
  if (const char* assets = std::getenv("HDWAVEFRONT_ASSETS")) return assets;
  return std::filesystem::path(HDWAVEFRONT_SOURCE_DIR) / "../shared/assets";
}

// All example materials of MaterialX that use the surfaces of this issue.
TEST(MaterialGen, MaterialXExamplesCompile) {
  const std::filesystem::path root = Assets() / "materialx/resources/Materials/Examples";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no assets at " << root << "; set HDWAVEFRONT_ASSETS";
  for (const char* folder : {"StandardSurface", "UsdPreviewSurface"}) {
    for (const auto& file : std::filesystem::directory_iterator(root / folder)) {
      if (file.path().extension() != ".mtlx") continue;
      const auto networks = materialgen_test::NetworksOf(file.path().string(), HDWAVEFRONT_MATERIALX_LIBRARIES);
      EXPECT_FALSE(networks.empty()) << file.path();
      for (const MaterialNetwork& network : networks) {
        const auto start = std::chrono::steady_clock::now();
        const Result result = RunNetwork(network);
        const auto generated = std::chrono::steady_clock::now();
        const size_t words = ExpectCompiles(result.material, file.path().filename().string());
        const auto compiled = std::chrono::steady_clock::now();
        for (const Message& m : result.messages) {
          EXPECT_NE(m.severity, Severity::Error) << file.path() << " " << m.code << " " << m.location << ": " << m.text;
        }
        const std::string& source = result.material.kernel->surface;
        const auto ms = [](auto from, auto to) { return std::chrono::duration<double, std::milli>(to - from).count(); };
        std::cout << file.path().filename().string() << ": " << std::count(source.begin(), source.end(), '\n')
                  << " lines, " << words * 4 / 1024 << " KiB SPIR-V, " << result.material.kernel->lobes.size()
                  << " lobes, generate " << ms(start, generated) << " ms, compile " << ms(generated, compiled)
                  << " ms\n";
      }
    }
  }
}

// Every document of MaterialX that there is: all its surfaces compile, and nothing of them is left out.
TEST(MaterialGen, MaterialXTestSuiteCompiles) {
  const std::filesystem::path root = Assets() / "materialx/resources/Materials";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "no assets at " << root << "; set HDWAVEFRONT_ASSETS";
  std::set<std::string> unsupported;
  size_t documents = 0, surfaces = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(root)) {
    if (file.path().extension() != ".mtlx") continue;
    ++documents;
    for (const MaterialNetwork& network :
         materialgen_test::NetworksOf(file.path().string(), HDWAVEFRONT_MATERIALX_LIBRARIES)) {
      ++surfaces;
      const Result result = RunNetwork(network);
      ExpectCompiles(result.material, file.path().filename().string());
      for (const Message& m : result.messages) {
        if (m.severity != Severity::Info)
          unsupported.insert(file.path().filename().string() + " " + m.code + ": " + m.text);
      }
    }
  }
  EXPECT_EQ(documents, 77u);
  EXPECT_EQ(surfaces, 120u);  // displacement.mtlx and lama_surface.mtlx have none
  // MaterialX's graph of OpenPBR does not read the dispersion that this document asks for.
  EXPECT_EQ(unsupported, std::set<std::string>{"open_pbr_glass.mtlx material-unsupported-feature: dispersion is ignored: all "
                                               "colours refract alike"});
}

// Every node of the library whose value is a number, its inputs varying. What is not supported is known here.
TEST(MaterialGen, AllLibraryNodesCompile) {
  std::set<std::string> unsupported;
  for (const MaterialNetwork& network : materialgen_test::NetworksOfAllNodes(HDWAVEFRONT_MATERIALX_LIBRARIES, 16)) {
    const Result result = RunNetwork(network);
    ExpectCompiles(result.material, network.path);
    for (const Message& m : result.messages) {
      if (m.severity == Severity::Error) unsupported.insert(m.text);
    }
  }
  EXPECT_EQ(unsupported, std::set<std::string>());
}

// To read generated code: HDWAVEFRONT_DUMP=file.mtlx hdwavefront_tests --gtest_also_run_disabled_tests --gtest_filter=*Dump
TEST(MaterialGen, DISABLED_Dump) {
  const char* file = std::getenv("HDWAVEFRONT_DUMP");
  ASSERT_NE(file, nullptr) << "set HDWAVEFRONT_DUMP to a .mtlx file to see its kernels";
  for (const MaterialNetwork& network : materialgen_test::NetworksOf(file, HDWAVEFRONT_MATERIALX_LIBRARIES)) {
    const Result result = RunNetwork(network);
    for (const Message& m : result.messages)
      std::cout << "// " << m.code << " " << m.location << ": " << m.text << "\n";
    std::cout << "// " << network.path << " " << result.material.kernel->key << "\n"
              << result.material.kernel->surface << result.material.kernel->opacity << result.material.kernel->emission;
  }
}

}  // namespace
}  // namespace materialgen
