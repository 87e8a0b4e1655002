#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::formats {

/// A handle of the HDF5 library, closed when it goes.
class Hdf5Handle {
 public:
  using Identifier = std::int64_t;  ///< hid_t
  using Close = int (*)(Identifier);

  Hdf5Handle(Identifier identifier, Close closer) : identifier_(identifier), close_(closer) {}
  ~Hdf5Handle() { (void)close(); }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : identifier_(std::exchange(other.identifier_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&&) = delete;

  [[nodiscard]] bool is_open() const { return identifier_ >= 0; }
  [[nodiscard]] Identifier get() const { return identifier_; }

  /// False: the library could not close it. Nothing is open afterwards.
  [[nodiscard]] bool close() {
    const Identifier identifier = std::exchange(identifier_, -1);
    return identifier < 0 || close_(identifier) >= 0;
  }

 private:
  Identifier identifier_;
  Close close_;
};

/// A new HDF5 file. Objects are named by their path ("/trials/0001"); groups on the way are made. Units stand
/// in an attribute `units` of each dataset. Errors (kIo) name the file, the object and what the system says.
///
/// The library stays loaded to the end of the process and does not tidy up then: a file that could not be
/// written would be written once more, and end the process with a signal.
class Hdf5File {
 public:
  /// kAlreadyExists, kIo.
  [[nodiscard]] static Result<Hdf5File> create(const std::filesystem::path& path);

  [[nodiscard]] Result<void> make_group(const std::string& path);

  /// Row-major, `columns` values a row; 0 columns: a vector.
  [[nodiscard]] Result<void> write(const std::string& path, std::span<const double> values,
                                   std::size_t columns, const std::string& units,
                                   const std::string& description);
  [[nodiscard]] Result<void> write(const std::string& path, std::span<const std::int64_t> values,
                                   const std::string& units, const std::string& description);
  [[nodiscard]] Result<void> write(const std::string& path, std::span<const std::uint8_t> values,
                                   const std::string& units, const std::string& description);

  /// Attributes of a group or dataset that is there.
  [[nodiscard]] Result<void> set(const std::string& path, const std::string& name, const std::string& text);
  [[nodiscard]] Result<void> set(const std::string& path, const std::string& name, double value);
  [[nodiscard]] Result<void> set(const std::string& path, const std::string& name, std::int64_t value);

  /// Closes the file; its content is on the disk. Nothing may be written afterwards.
  [[nodiscard]] Result<void> finish();

 private:
  Hdf5File(std::filesystem::path path, Hdf5Handle file) : path_(std::move(path)), file_(std::move(file)) {}
  [[nodiscard]] Error error(const std::string& object) const;
  [[nodiscard]] Result<void> write_data(const std::string& path, Hdf5Handle::Identifier type,
                                        const void* data, std::span<const std::uint64_t> shape,
                                        const std::string& units, const std::string& description);
  [[nodiscard]] Result<void> set_data(const std::string& path, const std::string& name,
                                      Hdf5Handle::Identifier type, const void* data);

  std::filesystem::path path_;
  Hdf5Handle file_;
};

}  // namespace tonus::formats
