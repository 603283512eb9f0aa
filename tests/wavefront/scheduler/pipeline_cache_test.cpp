// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "wavefront/scheduler/pipeline_cache_file.h"

namespace wavefront {
namespace {

TEST(PipelineCacheFile, ComesBackWholeOrNotAtAll) {
  std::string folder = (std::filesystem::temp_directory_path() / "hdwavefront-pipelines-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  vulkan::DeviceInfo info;
  info.name = "A GPU / 2";
  info.driverName = "driver";
  info.driverVersion = "1.2";
  const std::string file = PipelineCacheFile(folder + "/new", info);
  EXPECT_EQ(file, folder + "/new/pipelines-A_GPU___2-driver-1.2");
  EXPECT_TRUE(PipelineCacheFile("", info).empty());
  EXPECT_TRUE(ReadPipelineCache(file).empty());
  std::vector<std::byte> data(5000);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::byte>(i * 7);
  ASSERT_TRUE(WritePipelineCache(file, data));
  EXPECT_EQ(ReadPipelineCache(file), data);
  std::filesystem::resize_file(file, 4000);
  EXPECT_TRUE(ReadPipelineCache(file).empty());
  ASSERT_TRUE(WritePipelineCache(file, data));
  {
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    stream.seekp(3000);
    stream.put('\x01');
  }
  EXPECT_TRUE(ReadPipelineCache(file).empty());
  EXPECT_FALSE(WritePipelineCache(file + "/below a file", data));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder + "/new"), {}), 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace wavefront
