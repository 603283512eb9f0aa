// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Result: the value, or what went wrong with the environment or the input (not bugs: see check.h).
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace wavefront {

struct Error {
  std::string message;  // one sentence that names what failed and, where known, what to do
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}        // NOLINT: implicit by design
  Result(Error error) : error_(std::move(error)) {}    // NOLINT: implicit by design
  explicit operator bool() const { return value_.has_value(); }
  bool ok() const { return value_.has_value(); }
  T& value() & { return *value_; }
  const T& value() const& { return *value_; }
  T&& value() && { return std::move(*value_); }
  T* operator->() { return &*value_; }
  T& operator*() { return *value_; }
  const Error& error() const { return error_; }

 private:
  std::optional<T> value_;
  Error error_;
};

// Success, or what went wrong.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)), ok_(false) {}  // NOLINT: implicit by design
  explicit operator bool() const { return ok_; }
  bool ok() const { return ok_; }
  const Error& error() const { return error_; }

 private:
  Error error_;
  bool ok_ = true;
};

}  // namespace wavefront
