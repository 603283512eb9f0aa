// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/options.h"

#include <algorithm>
#include <charconv>
#include <functional>

#include "plugin/bench/sweeps.h"

namespace bench {
namespace {

bool ReadNumber(std::string_view text, uint32_t* number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  return error == std::errc() && end == text.data() + text.size();
}

bool ReadNumbers(std::string_view text, std::vector<uint32_t>* numbers) {
  numbers->clear();
  for (;;) {
    const std::size_t comma = text.find(',');
    if (!ReadNumber(text.substr(0, comma), &numbers->emplace_back())) return false;
    if (comma == std::string_view::npos) return true;
    text.remove_prefix(comma + 1);
  }
}

bool ReadReal(std::string_view text, double* number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  return error == std::errc() && end == text.data() + text.size();
}

struct Flag {
  const char *name, *value, *doc;  // value null: a switch
  std::function<bool(Options&, const std::string&)> read;
};

std::string SweepNames(const char* between) {
  std::string names;
  for (const Sweep& sweep : Sweeps()) names += (names.empty() ? "" : between) + std::string(sweep.name);
  return names;
}

const std::vector<Flag>& Flags() {
  const auto text = [](std::string Options::*field) { return [field](Options& o, const std::string& v) { o.*field = v; return !v.empty(); }; };
  const auto number = [](uint32_t Options::*field) { return [field](Options& o, const std::string& v) { return ReadNumber(v, &(o.*field)); }; };
  const auto on = [](bool Options::*field) { return [field](Options& o, const std::string&) { return o.*field = true; }; };
  static const std::vector<Flag> flags{
      {"--sweep", "NAME", "scenes made here, each larger than the one before; NAME is one of those below",
       [](Options& o, const std::string& v) { o.sweep = v; return FindSweep(v) != nullptr; }},
      {"--points", "N,N,...", "sizes of the sweep's scenes in place of its own",
       [](Options& o, const std::string& v) { return ReadNumbers(v, &o.points) && std::find(o.points.begin(), o.points.end(), 0u) == o.points.end(); }},
      {"--quick", nullptr, "fewer and smaller scenes of the sweep, one run of each", on(&Options::quick)},
      {"--rays", nullptr, "cast rays through the scenes instead of rendering them: the camera's, and two bounces of them", on(&Options::rays)},
      {"--mode", "MODE", "wavefront, megakernel or both (default)",
       [](Options& o, const std::string& v) {
         o.wavefront = v != "megakernel";
         o.megakernel = v != "wavefront";
         return v == "wavefront" || v == "megakernel" || v == "both";
       }},
      {"--runs", "N", "renders of each mode, the modes in turn; the median is shown (default 3)",
       [number](Options& o, const std::string& v) { return number(&Options::runs)(o, v) && o.runs >= 1 && o.runs <= 1000; }},
      {"--samples", "N", "samples a pixel, in place of the scene's", number(&Options::samples)},
      {"--seconds", "N", "raise the samples until a render takes as long and fills its pool 16 times, if the slowest ends within 5 times as\n"
       "                        long; 0: don't (default: 1 in sweeps, 0.2 with --quick, 0 for files and where --samples is given)",
       [](Options& o, const std::string& v) { return ReadReal(v, &o.seconds) && o.seconds >= 0 && o.seconds <= 3600; }},
      {"--width", "N", "pixels, in place of the scene's; the height follows unless it is given", number(&Options::width)},
      {"--height", "N", "pixels", number(&Options::height)},
      {"--pool", "N,N,...", "paths in flight, each in turn; 0: what suits the device (default)",
       [](Options& o, const std::string& v) { return ReadNumbers(v, &o.pools); }},
      {"--device", "DEVICE", "index, or part of the name (default: $HDWAVEFRONT_DEVICE, else the best)", text(&Options::device)},
      {"--validate", nullptr, "with Vulkan's validation layer; its messages are counted, and any makes the exit code 3", on(&Options::validate)},
      {"--json", "FILE", "write what is printed, and more, as JSON", text(&Options::json)},
      {"--image", "FILE.pfm", "write the last picture's colour, scene-linear, as a portable float map", text(&Options::image)},
      {"--compare", nullptr, "say what differs between two scene files, a line a field, and render nothing", on(&Options::compare)},
      {"--write", "FILE", "write the last scene of a sweep as a scene file, and render nothing", text(&Options::write)},
      {"--listDevices", nullptr, "print the Vulkan devices and end", on(&Options::listDevices)},
      {"--help", nullptr, "print this and end", on(&Options::help)},
  };
  return flags;
}

}  // namespace

wavefront::Result<Options> ParseOptions(std::span<const char* const> arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string argument = arguments[i];
    if (!argument.starts_with("--")) {
      options.files.push_back(argument);
      continue;
    }
    const auto flag = std::find_if(Flags().begin(), Flags().end(), [&](const Flag& f) { return f.name == argument; });
    if (flag == Flags().end()) return wavefront::Error{"There is no option " + argument + "."};
    std::string value;
    if (flag->value) {
      if (++i == arguments.size()) return wavefront::Error{argument + " wants a value: " + flag->value + "."};
      value = arguments[i];
    }
    if (!flag->read(options, value)) return wavefront::Error{argument + " does not take '" + value + "': " + flag->doc + "."};
  }
  if (options.pools.empty()) options.pools = {0};
  if (options.quick) options.runs = 1;
  if (options.help || options.listDevices) return options;
  if (options.files.empty() == options.sweep.empty())
    return wavefront::Error{options.sweep.empty() ? "A scene file or --sweep is wanted." : "Scene files and --sweep cannot both be given."};
  if (options.compare && options.files.size() != 2) return wavefront::Error{"--compare wants two scene files."};
  if (!options.write.empty() && options.sweep.empty()) return wavefront::Error{"--write goes with --sweep."};
  if (options.seconds < 0) {
    const bool own = options.sweep.empty() || options.samples != 0 || FindSweep(options.sweep)->ownSamples;
    options.seconds = own ? 0 : options.quick ? 0.2 : 1;
  }
  return options;
}

std::string Usage() {
  std::string text =
      "usage: wavefront-bench FILE... [options]     replay scenes that `hdwavefront capture` wrote\n"
      "       wavefront-bench --sweep NAME [options]   scenes made here: " + SweepNames(", ") + "\n\n"
      "Renders each scene by the wavefront loop and by the megakernel in turn, after one render of each that is not counted,\n"
      "and says how fast, where the time went, and whether the pictures are the same to the bit.\n"
      "Exit codes: 0 done; 1 input or environment failed; 2 wrong usage; 3 pictures or scenes differ, or validation messages.\n\n";
  for (const Flag& flag : Flags()) {
    std::string left = std::string("  ") + flag.name + (flag.value ? std::string(" ") + flag.value : "");
    left.resize(std::max<std::size_t>(left.size() + 1, 24), ' ');
    text += left + flag.doc + "\n";
  }
  text += "\nsweeps:\n";
  for (const Sweep& sweep : Sweeps()) {
    std::string left = std::string("  ") + sweep.name;
    left.resize(24, ' ');
    text += left + sweep.doc + "\n";
  }
  return text;
}

}  // namespace bench
