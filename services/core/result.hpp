#pragma once

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

namespace detail {
/// Prints one line on standard error and aborts: a Result was read as what it is not.
[[noreturn]] void stop_on_error(const Error& error);
[[noreturn]] void stop_on_value();
}  // namespace detail

/// Either a value or an Error. Reading the wrong alternative is a programming fault and aborts the program,
/// in every build type, with the error's message.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value)
      : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Error error)
      : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() & { return *checked(); }
  [[nodiscard]] const T& value() const& { return *checked(); }
  [[nodiscard]] T&& value() && { return std::move(*checked()); }
  [[nodiscard]] const Error& error() const {
    if (const Error* error = std::get_if<1>(&state_)) return *error;
    detail::stop_on_value();
  }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  T* checked() {
    if (T* value = std::get_if<0>(&state_)) return value;
    detail::stop_on_error(*std::get_if<1>(&state_));
  }
  const T* checked() const { return const_cast<Result*>(this)->checked(); }

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
  [[nodiscard]] const Error& error() const {
    if (!failed_) detail::stop_on_value();
    return error_;
  }

 private:
  Error error_;
  bool failed_ = false;
};

}  // namespace tonus

// Propagation of errors, for functions that return a Result. `expression` is evaluated once.
#define TONUS_JOIN_(a, b) a##b
#define TONUS_JOIN(a, b) TONUS_JOIN_(a, b)
#define TONUS_TRY_ASSIGN_(result, target, expression) \
  auto result = (expression);                         \
  if (!result) return result.error();                 \
  target = *std::move(result)

/// TONUS_TRY(expression): returns its error from this function, or goes on.
#define TONUS_TRY(expression)                                                                     \
  do {                                                                                            \
    if (auto tonus_try_result = (expression); !tonus_try_result) return tonus_try_result.error(); \
  } while (false)

/// TONUS_TRY_ASSIGN(auto x, expression): x becomes the value, or this function returns the error. Two
/// statements: not for use as the body of an if without braces.
#define TONUS_TRY_ASSIGN(target, ...) \
  TONUS_TRY_ASSIGN_(TONUS_JOIN(tonus_try_result_, __LINE__), target, (__VA_ARGS__))
