// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The statistics that hosts read, by name and type, and what kernels, queues and materials cost.
#include "plugin/hydra/stats.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/hydra/host.h"

namespace hydra_test {
namespace {

template <typename T>
T StatOf(const VtDictionary& stats, const std::string& name) {
  const auto found = stats.find(name);
  if (found == stats.end() || !found->second.IsHolding<T>()) {
    ADD_FAILURE() << name << (found == stats.end() ? " is missing" : " is a " + found->second.GetTypeName());
    return T();
  }
  return found->second.UncheckedGet<T>();
}

TEST(Stats, HoldWhatHostsReadInTheTypesTheyExpect) {
  delegate_test::EditScript script(3);
  Host host;
  const auto read = [&] { return host.renderDelegate.GetRenderStats(); };
  EXPECT_EQ(StatOf<double>(read(), "percentDone"), 0);
  script.Populate(host.sink);
  host.Execute(script.scene());
  host.Finish();
  const VtDictionary done = read();
  EXPECT_EQ(StatOf<double>(done, "percentDone"), 100);
  EXPECT_EQ(StatOf<double>(done, "fractionDone"), 1);
  EXPECT_EQ(StatOf<int>(done, "numCompletedSamples"), 2);
  EXPECT_GT(StatOf<double>(done, "totalClockTime"), 0);
  EXPECT_EQ(StatOf<std::string>(done, "rendererName"), "Wavefront");
  EXPECT_EQ(StatOf<std::string>(done, "rendererStage"), "done");
  EXPECT_EQ(StatOf<std::string>(done, "renderProgressAnnotation"), "done, 2 samples");
  EXPECT_GT(StatOf<uint64_t>(done, "gpuMemoryUsed"), 0u);
  EXPECT_EQ(StatOf<uint64_t>(done, "totalMemory"), StatOf<uint64_t>(done, "gpuMemoryUsed"));
  EXPECT_GE(StatOf<uint64_t>(done, "peakMemory"), StatOf<uint64_t>(done, "totalMemory"));
  EXPECT_EQ(StatOf<int>(done, "huskErrorStatus"), 0);
  host.renderDelegate.Pause();
  host.renderDelegate.Stop();
  EXPECT_EQ(StatOf<std::string>(read(), "rendererStage"), "stopped");
}

TEST(Stats, TellWhatKernelsQueuesAndMaterialsCost) {
  delegate_test::EditScript script(3);
  Host host;
  script.Populate(host.sink);
  host.Execute(script.scene());
  host.Finish();
  const VtDictionary stats = host.renderDelegate.GetRenderStats();
  EXPECT_GE(StatOf<double>(stats, "kernel:logic:ms"), 0);
  EXPECT_GT(StatOf<uint64_t>(stats, "kernel:logic:items"), 0u);
  EXPECT_GT(StatOf<uint64_t>(stats, "queue:extensionRay:peak"), 0u);
  EXPECT_EQ(StatOf<uint64_t>(stats, "kernel:extension_ray:peak"), StatOf<uint64_t>(stats, "queue:extensionRay:peak"));
  for (const char* name : {"kernel:extension_ray:occupancy", "queue:extensionRay:occupancy"}) {
    EXPECT_GT(StatOf<double>(stats, name), 0) << name;
    EXPECT_LE(StatOf<double>(stats, name), 1) << name;
  }
  EXPECT_EQ(StatOf<double>(stats, "queue:extensionRay:ms"), StatOf<double>(stats, "kernel:extension_ray:ms"));
  EXPECT_GE(StatOf<uint64_t>(stats, "queue:extensionRay:items"), StatOf<uint64_t>(stats, "queue:extensionRay:peak"));
  // What the floor and the box wear is in the picture. Kernels that materials share are told with each of them.
  for (const std::string path : {"/looks/plain", "/looks/wood"}) {
    const std::string name = "material:" + path + ":", key = StatOf<std::string>(stats, name + "kernel");
    const uint64_t items = StatOf<uint64_t>(stats, "kernel:material:" + key + ":surface:items");
    EXPECT_GT(items, 0u) << path;
    EXPECT_GE(StatOf<uint64_t>(stats, name + "paths"), items);
    const double share = StatOf<double>(stats, name + "share");
    EXPECT_GE(share, 0);
    EXPECT_LE(share, 1);
    EXPECT_GE(StatOf<double>(stats, name + "ms"), StatOf<double>(stats, "kernel:material:" + key + ":surface:ms"));
    EXPECT_GE(StatOf<double>(stats, name + "nsPerPath"), 0);
  }
}

// UsdImaging empties materials of source types that a renderer does not name, and nothing could tell of them.
TEST(RenderDelegate, MaterialsOfSourceFilesArriveSoThatTheyAreToldOf) {
  Host host(delegate_test::MakeRealDelegate(2, /*captureOnly=*/true));
  const TfTokenVector types = host.renderDelegate.GetShaderSourceTypes();
  for (const TfToken& context : host.renderDelegate.GetMaterialRenderContexts())
    EXPECT_EQ(std::ranges::count(types, context), 1) << context;
  EXPECT_EQ(std::ranges::count(types, TfToken("glslfx")), 1);
}

}  // namespace
}  // namespace hydra_test
