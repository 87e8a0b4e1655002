#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace tonus {

/// What kind of failure an Error is; callers branch on this, people read the message.
enum class ErrorCode {
  kInvalidArgument,  ///< A value is outside what is allowed; the message says which, its value and the limit.
  kNotFound,         ///< A named thing (file, trial, session) does not exist.
  kAlreadyExists,    ///< A thing that must be unique is there already.
  kTimeout,          ///< Something was not done within its time; it may be tried again.
  kUnavailable,      ///< A peer or a resource is not there now.
  kDataLoss,         ///< Data are damaged or missing.
  kIo,               ///< The operating system refused a read, write or sync.
  kInternal,         ///< A broken promise inside the program.
};

/// A failure: its kind, and one line for a person that names the thing, its value and what is allowed.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
};

/// Makes an error in one expression: `return fail(ErrorCode::kNotFound, "...")`.
[[nodiscard]] inline Error fail(ErrorCode code, std::string message) { return {code, std::move(message)}; }

/// Either a value or an Error. Reading the wrong alternative is a programming fault and asserts.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value)
      : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Error error)
      : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() & { return assert(has_value()), *std::get_if<0>(&state_); }
  [[nodiscard]] const T& value() const& { return assert(has_value()), *std::get_if<0>(&state_); }
  [[nodiscard]] T&& value() && { return assert(has_value()), std::move(*std::get_if<0>(&state_)); }
  [[nodiscard]] const Error& error() const { return assert(!has_value()), *std::get_if<1>(&state_); }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> state_;
};

/// Success, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)), failed_(true) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool has_value() const { return !failed_; }
  explicit operator bool() const { return !failed_; }
  [[nodiscard]] const Error& error() const { return assert(failed_), error_; }

 private:
  Error error_;
  bool failed_ = false;
};

}  // namespace tonus
