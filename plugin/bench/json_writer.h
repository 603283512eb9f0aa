// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Writes JSON, value by value.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>

namespace bench {

class JsonWriter {
 public:
  JsonWriter& Begin(char bracket) {  // { or [
    Separate();
    text_ += bracket;
    fresh_ = true;
    return *this;
  }
  JsonWriter& End(char bracket) {
    text_ += bracket;
    fresh_ = false;
    return *this;
  }
  JsonWriter& Key(std::string_view name) {
    Separate();
    Quote(name);
    text_ += ": ";
    fresh_ = true;
    return *this;
  }
  void Value(std::string_view text) {
    Separate();
    Quote(text);
  }
  void Value(const char* text) { Value(std::string_view(text)); }
  void Value(bool value) {
    Separate();
    text_ += value ? "true" : "false";
  }
  template <typename T>
    requires std::is_arithmetic_v<T>
  void Value(T number) {
    Separate();
    char digits[40];
    if constexpr (std::is_integral_v<T>) std::snprintf(digits, sizeof digits, "%lld", static_cast<long long>(number));
    else if (std::isfinite(number)) std::snprintf(digits, sizeof digits, "%.9g", static_cast<double>(number));
    else std::snprintf(digits, sizeof digits, "null");
    text_ += digits;
  }
  template <typename T>
  JsonWriter& Pair(std::string_view name, const T& value) {
    Key(name).Value(value);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  void Separate() {
    if (!fresh_) text_ += ", ";
    fresh_ = false;
  }
  void Quote(std::string_view text) {
    text_ += '"';
    for (const char c : text) {
      const auto code = static_cast<unsigned char>(c);
      if (c == '"' || c == '\\') text_ += '\\';
      if (code < 0x20) {
        char escape[8];
        std::snprintf(escape, sizeof escape, "\\u%04x", code);
        text_ += escape;
      } else {
        text_ += c;
      }
    }
    text_ += '"';
  }

  std::string text_;
  bool fresh_ = true;
};

}  // namespace bench
