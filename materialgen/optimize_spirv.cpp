// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What every driver does with a program before it does anything else - inlining, variables to values, constants - done once
// and kept with the program in the cache. lavapipe does not keep it: it takes 75 to 175 ms for each kernel, for each device
// and in every process, and 15 to 30 ms of a program that comes so.
//
// The passes (wavefront/kernels/spirv_passes.txt, for the fixed kernels too) are those of `spirv-opt -O` without
// --simplify-instructions, which regroups arithmetic of numbers: a kernel and the same code in the megakernel would no longer
// give the same bits.
#include <sstream>
#include <string>

#include <spirv-tools/optimizer.hpp>

#include "materialgen/materialgen.h"

namespace materialgen {

std::vector<uint32_t> OptimizeSpirv(std::vector<uint32_t> spirv) {
  if (spirv.empty() || InlinedInstructions(spirv) > kOptimizedInstructions) return spirv;
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
  optimizer.SetMessageConsumer([](spv_message_level_t, const char*, const spv_position_t&, const char*) {});
  std::istringstream passes(HDWAVEFRONT_SPIRV_PASSES);
  for (std::string pass; passes >> pass;) {
    if (!optimizer.RegisterPassFromFlag(pass)) return spirv;  // tested: all of them are known
  }
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);  // it is glslang's output
  std::vector<uint32_t> optimized;
  return optimizer.Run(spirv.data(), spirv.size(), &optimized, options) ? optimized : spirv;
}

}  // namespace materialgen
