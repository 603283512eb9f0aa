// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/kernel_compiler.h"

#include <algorithm>
#include <iterator>

#include "wavefront/vulkan/command_stream.h"

namespace wavefront {
namespace {

using Clock = std::chrono::steady_clock;
double Seconds(Clock::time_point from) { return std::chrono::duration<double>(Clock::now() - from).count(); }

// Mesa writes its cache from a thread of its own, a moment after the dispatch. A rendering device that comes too early
// compiles once more, in the render thread: slow, not wrong.
constexpr auto kCacheWriteTime = std::chrono::milliseconds(60);
// A dispatch that found the code in the cache is faster than this.
constexpr double kCompiledSeconds = 0.025;

// The first word of an instruction has its length in the upper half; the module's head is five words.
uint64_t CountInstructions(const std::vector<uint32_t>& spirv) {
  uint64_t count = 0;
  for (std::size_t at = 5; at < spirv.size(); at += std::max(1u, spirv[at] >> 16)) ++count;
  return count;
}

}  // namespace

// A device of this thread's own, with a set that looks to the driver as the renderer's (formats of the layout, sizes as
// BufferDesc::texels has them): lavapipe compiles for what it finds bound, and would compile again otherwise. One queue compiles
// serially, several devices side by side.
struct KernelCompiler::WarmDevice {
  std::unique_ptr<vulkan::Device> device;
  std::unique_ptr<vulkan::PipelineLayout> layout;
  std::unique_ptr<vulkan::DescriptorSet> set;
  std::unique_ptr<vulkan::CommandStream> stream;

  static Result<std::unique_ptr<WarmDevice>> Create(const vulkan::Device& like, const vulkan::PipelineLayout& likeLayout) {
    auto warm = std::make_unique<WarmDevice>();
    vulkan::DeviceOptions options;
    options.selector = std::to_string(like.info().index);
    options.neverValidate = true;  // the rendering device, which is validated, is given the same programs
    auto device = vulkan::Device::Create(options);
    if (!device) return device.error();
    warm->device = std::move(device).value();
    auto layout = vulkan::PipelineLayout::Create(*warm->device, likeLayout.bindings(), "warm-up");
    if (!layout) return layout.error();
    warm->layout = std::move(layout).value();
    auto set = vulkan::DescriptorSet::Create(*warm->device, *warm->layout, "warm-up");
    if (!set) return set.error();
    warm->set = std::move(set).value();
    auto stream = vulkan::CommandStream::Create(*warm->device, {1, 0, "warm-up"});
    if (!stream) return stream.error();
    warm->stream = std::move(stream).value();
    return warm;
  }

  Status Dispatch(const vulkan::PipelineDesc& desc, CompileCost* cost) {
    auto pipeline = vulkan::ComputePipeline::Create(*device, *layout, desc);
    if (!pipeline) return pipeline.error();
    cost->createSeconds += pipeline.value()->creationSeconds();
    const auto start = Clock::now();
    if (Status s = stream->Begin(); !s) return s;
    stream->BindSet(*set);
    stream->BindPipeline(*pipeline.value());
    const uint32_t push[4] = {};
    stream->PushConstants(std::as_bytes(std::span(push)));
    stream->Dispatch(0, 1, 1);
    auto value = stream->Submit();
    if (!value) return value.error();
    if (auto done = stream->Wait(value.value()); !done) return done.error();
    cost->firstDispatchSeconds = Seconds(start);
    return {};
  }
};

KernelCompiler::KernelCompiler(vulkan::Device& device, const vulkan::PipelineLayout& layout, unsigned threads)
    : device_(device), layout_(layout), driverCompile_(vulkan::DriverCompileOf(device.info(), &whyNoCache_)),
      threadCount_(std::clamp(threads, 1u, 16u)) {}

KernelCompiler::~KernelCompiler() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    queue_.clear();
    cacheQueue_.clear();
  }
  work_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void KernelCompiler::Enqueue(std::vector<Job> jobs) {
  std::lock_guard lock(mutex_);
  for (Job& job : jobs) queue_.push_back(std::move(job));
  // Threads are made when there is work for them: most edits compile nothing.
  while (threads_.size() < std::min<std::size_t>(threadCount_, queue_.size())) threads_.emplace_back([this] { Run(); });
  work_.notify_all();
}

void KernelCompiler::EnqueueFirst(std::vector<CacheJob> jobs) {
  if (driverCompile_ != vulkan::DriverCompile::AtDispatchCached) return;
  std::lock_guard lock(mutex_);
  cacheQueue_.insert(cacheQueue_.end(), jobs.begin(), jobs.end());
  while (threads_.size() < std::min<std::size_t>(threadCount_, cacheQueue_.size())) threads_.emplace_back([this] { Run(); });
  work_.notify_all();
}

bool KernelCompiler::TakeBack(uint32_t id) {
  std::lock_guard lock(mutex_);
  return std::erase_if(cacheQueue_, [&](const CacheJob& job) { return job.id == id; }) != 0;
}

void KernelCompiler::WaitForCacheJobs() {
  std::unique_lock lock(mutex_);
  finished_.wait(lock, [this] { return cacheQueue_.empty() && cacheJobsInWork_ == 0; });
  const auto written = cacheWritten_;
  lock.unlock();
  std::this_thread::sleep_until(written);
}

std::vector<KernelCompiler::Done> KernelCompiler::Take() {
  std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  const auto early = std::stable_partition(done_.begin(), done_.end(), [&](const Done& d) { return d.readyAt <= now; });
  std::vector<Done> taken(std::move_iterator(done_.begin()), std::move_iterator(early));
  done_.erase(done_.begin(), early);
  return taken;
}

std::size_t KernelCompiler::finished() const {
  std::lock_guard lock(mutex_);
  return done_.size();
}

void KernelCompiler::Wait(double seconds) {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  std::unique_lock lock(mutex_);
  for (;;) {
    auto until = end;
    for (const Done& done : done_) until = std::min(until, done.readyAt);
    if (until <= Clock::now()) return;
    finished_.wait_until(lock, until);
  }
}

void KernelCompiler::Run() {
  std::unique_ptr<WarmDevice> warm;
  std::unique_lock lock(mutex_);
  for (;;) {
    if (queue_.empty() && cacheQueue_.empty() && !stop_) {
      // A device that waits for the next edit would only hold memory.
      lock.unlock();
      warm.reset();
      lock.lock();
    }
    work_.wait(lock, [this] { return stop_ || !queue_.empty() || !cacheQueue_.empty(); });
    if (stop_) return;
    if (!cacheQueue_.empty()) {
      const CacheJob job = cacheQueue_.front();
      cacheQueue_.pop_front();
      ++cacheJobsInWork_;
      lock.unlock();
      CompileCost cost;
      std::string trouble;
      // A failure is the rendering device's to find.
      if (WarmDevice* device = Warm(warm, &trouble)) (void)device->Dispatch(*job.desc, &cost);
      lock.lock();
      --cacheJobsInWork_;
      if (cost.firstDispatchSeconds > kCompiledSeconds) cacheWritten_ = Clock::now() + kCacheWriteTime;
      finished_.notify_all();
      continue;
    }
    const Job job = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    Done done = Compile(job, warm);
    lock.lock();
    done_.push_back(std::move(done));
    finished_.notify_all();
  }
}

// The thread's device. Null where none can be had, then the rendering device compiles: slower, and the same picture.
KernelCompiler::WarmDevice* KernelCompiler::Warm(std::unique_ptr<WarmDevice>& warm, std::string* trouble) {
  if (!warm) {
    auto created = WarmDevice::Create(device_, layout_);
    if (created) warm = std::move(created).value();
    else *trouble = created.error().message;
  }
  return warm.get();
}

KernelCompiler::Done KernelCompiler::Compile(const Job& job, std::unique_ptr<WarmDevice>& warm) {
  Done done;
  done.bucket = job.bucket;
  const KernelCode code = job.code();
  done.cost.codeMilliseconds = code.milliseconds;
  done.cost.codeFromCache = code.fromCache;
  done.cost.spirvBytes = code.spirv.size() * 4;
  done.cost.spirvInstructions = CountInstructions(code.spirv);
  done.cost.state = StateTrafficOf(code.spirv);
  if (code.spirv.empty()) {
    done.error = code.error;
    return done;
  }
  done.readyAt = Clock::now();
  if (driverCompile_ == vulkan::DriverCompile::AtDispatchCached) {
    if (WarmDevice* device = Warm(warm, &done.trouble)) {
      if (Status s = device->Dispatch({code.spirv, "main", {}, job.name}, &done.cost); !s) {
        done.error = s.error().message;
        return done;
      }
    }
    if (done.cost.firstDispatchSeconds > kCompiledSeconds) done.readyAt = Clock::now() + kCacheWriteTime;
  }
  auto pipeline = vulkan::ComputePipeline::Create(device_, layout_, {code.spirv, "main", {}, job.name});
  if (!pipeline) {
    done.error = pipeline.error().message;
    return done;
  }
  done.pipeline = std::move(pipeline).value();
  done.cost.createSeconds += done.pipeline->creationSeconds();
  done.cost.driverStatistics = done.pipeline->DriverStatistics();
  return done;
}

}  // namespace wavefront
