// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A mutex that serves threads in the order in which they asked. With a plain one, a thread that unlocks and locks again
// at once keeps all others out: the render thread its mapping hosts, or a host that polls the render.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace wavefront {

// BasicLockable: std::lock_guard, std::unique_lock. Not recursive.
class FairMutex {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    const uint64_t ticket = next_++;
    changed_.wait(lock, [&] { return serving_ == ticket; });
  }
  void unlock() {
    {
      std::lock_guard lock(mutex_);
      ++serving_;
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t next_ = 0, serving_ = 0;
};

}  // namespace wavefront
