// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/spirv_cache.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

namespace materialgen {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<uint32_t>;

class SpirvCacheTest : public ::testing::Test {
 protected:
  SpirvCacheTest() {
    std::string name = (fs::temp_directory_path() / "hdwavefront-cache-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~SpirvCacheTest() override { fs::remove_all(folder_); }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_)) files.push_back(entry.path());
    return files;
  }
  std::string folder_;
};

Words Code(uint32_t seed, size_t size = 1000) {
  Words words(size);
  for (size_t i = 0; i < size; ++i) words[i] = seed + static_cast<uint32_t>(i) * 2654435761u;
  return words;
}

TEST_F(SpirvCacheTest, WhatWasStoredComesBackInAnotherRun) {
  SpirvCache(folder_).Store("source", Code(1));
  SpirvCache cache(folder_);
  EXPECT_EQ(cache.Load("source"), Code(1));
  EXPECT_FALSE(cache.Load("source of another kernel"));
  EXPECT_EQ(cache.hits(), 1u);
  EXPECT_EQ(cache.misses(), 1u);
  EXPECT_TRUE(cache.trouble().empty());
}

TEST_F(SpirvCacheTest, AnEmptyFolderNameSwitchesItOff) {
  SpirvCache cache("");
  cache.Store("source", Code(1));
  EXPECT_FALSE(cache.Load("source"));
}

TEST_F(SpirvCacheTest, DamagedEntriesAreMadeAnew) {
  const auto damage = [&](const char* what, const std::function<void(std::fstream&, const fs::path&)>& change) {
    SCOPED_TRACE(what);
    SpirvCache cache(folder_);
    cache.Store("source", Code(7));
    ASSERT_EQ(Files().size(), 1u);
    const fs::path path = Files()[0];
    {
      std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
      change(file, path);
    }
    EXPECT_FALSE(cache.Load("source"));
    cache.Store("source", Code(7));
    EXPECT_EQ(cache.Load("source"), Code(7));
  };
  damage("cut off", [](std::fstream&, const fs::path& path) { fs::resize_file(path, fs::file_size(path) - 4); });
  damage("cut off in the header", [](std::fstream&, const fs::path& path) { fs::resize_file(path, 20); });
  damage("empty", [](std::fstream&, const fs::path& path) { fs::resize_file(path, 0); });
  damage("longer", [](std::fstream&, const fs::path& path) { fs::resize_file(path, fs::file_size(path) + 4); });
  damage("a bit of the code", [](std::fstream& file, const fs::path&) {
    file.seekp(600);
    file.put('\x5a');
  });
  damage("the length", [](std::fstream& file, const fs::path&) {
    file.seekp(22);
    file.put('\x7f');
  });
  damage("of another source", [&](std::fstream&, const fs::path& path) {
    SpirvCache other(folder_ + "/other");
    other.Store("other source", Code(8));
    fs::path entry;
    for (const auto& file : fs::directory_iterator(folder_ + "/other")) entry = file.path();
    fs::rename(entry, path);
    fs::remove_all(folder_ + "/other");
  });
}

TEST_F(SpirvCacheTest, AFolderThatCannotBeUsedIsSaidAndNoError) {
  const std::string file = folder_ + "/file";
  std::ofstream(file) << "no folder";
  SpirvCache cache(file);
  cache.Store("source", Code(1));
  EXPECT_FALSE(cache.Load("source"));
  EXPECT_NE(cache.trouble().find(file), std::string::npos);
}

TEST_F(SpirvCacheTest, AFolderThatMayOnlyBeReadServes) {
  SpirvCache(folder_).Store("source", Code(1));
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  SpirvCache cache(folder_);
  EXPECT_EQ(cache.Load("source"), Code(1));
  cache.Store("more", Code(2));
  if (geteuid() != 0) {  // nothing is read-only to root
    EXPECT_FALSE(cache.trouble().empty());
  }
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(SpirvCacheTest, AFullDiskLeavesNothingBehind) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};  // bytes of any file: what a full disk looks like to a writer
    setrlimit(RLIMIT_FSIZE, &limit);
    SpirvCache cache(folder_);
    cache.Store("source", Code(1, 100000));
    _exit(cache.trouble().empty() || cache.Load("source") ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(Files().empty());
}

TEST_F(SpirvCacheTest, ManyProcessesWriteReadAndAreKilled) {
  constexpr uint32_t kSources = 8;
  const auto source = [](uint32_t i) { return "source " + std::to_string(i); };
  std::vector<pid_t> children;
  for (int c = 0; c < 4; ++c) {
    const pid_t child = fork();
    if (child == 0) {
      SpirvCache cache(folder_);
      for (uint32_t round = 0; round < 100000; ++round) {
        const uint32_t i = round % kSources;
        cache.Store(source(i), Code(i, 20000));
        const auto words = cache.Load(source((i + 3) % kSources));
        if (words && *words != Code((i + 3) % kSources, 20000)) _exit(1);  // half an entry was seen
      }
      _exit(0);
    }
    children.push_back(child);
  }
  usleep(400'000);
  for (pid_t child : children) kill(child, SIGKILL);
  for (pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status)) << "a child saw a broken entry";
  }
  SpirvCache cache(folder_);
  for (uint32_t i = 0; i < kSources; ++i) EXPECT_EQ(cache.Load(source(i)), Code(i, 20000)) << i;
  // What the killed ones left half written goes when it is old.
  for (const fs::path& path : Files())
    if (path.string().find(".part-") != std::string::npos)
      fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(2));
  cache.Store("one more", Code(9));
  for (const fs::path& path : Files()) EXPECT_EQ(path.string().find(".part-"), std::string::npos) << path;
}

TEST_F(SpirvCacheTest, TheEntriesUsedLeastRecentlyGo) {
  constexpr uint64_t kBytes = 40'000;  // nine entries of 4 KiB
  for (uint32_t i = 0; i < 30; ++i) {
    SpirvCache cache(folder_, kBytes);
    cache.Store("source " + std::to_string(i), Code(i));
    // Clocks of file systems are coarse: age what is there by hand, the first entry excepted.
    for (const fs::path& path : Files())
      fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(10));
    EXPECT_TRUE(cache.Load("source 0")) << i;  // used, so it stays
  }
  uint64_t bytes = 0;
  for (const fs::path& path : Files()) bytes += fs::file_size(path);
  EXPECT_LE(bytes, kBytes);
  SpirvCache cache(folder_, kBytes);
  EXPECT_TRUE(cache.Load("source 29"));
  EXPECT_FALSE(cache.Load("source 5"));
}

TEST_F(SpirvCacheTest, TheEnvironmentMovesItAndSwitchesItOff) {
  const auto with = [](const char* own, const char* xdg) {
    own ? setenv("HDWAVEFRONT_CACHE_DIR", own, 1) : unsetenv("HDWAVEFRONT_CACHE_DIR");
    xdg ? setenv("XDG_CACHE_HOME", xdg, 1) : unsetenv("XDG_CACHE_HOME");
    return SpirvCache::DefaultFolder();
  };
  const char* own = std::getenv("HDWAVEFRONT_CACHE_DIR");
  const char* xdg = std::getenv("XDG_CACHE_HOME");
  const std::string ownBefore = own ? own : "", xdgBefore = xdg ? xdg : "";
  EXPECT_EQ(with("/a", "/b"), "/a/spirv");
  EXPECT_EQ(with("off", "/b"), "");
  EXPECT_EQ(with(nullptr, "/b"), "/b/hdwavefront/spirv");
  with(own ? ownBefore.c_str() : nullptr, xdg ? xdgBefore.c_str() : nullptr);
}

}  // namespace
}  // namespace materialgen
