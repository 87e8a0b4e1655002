#include "services/formats/hdf5_file.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <spdlog/fmt/fmt.h>
#include <string_view>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"
#include "services/core/text_file.hpp"

namespace tonus::formats {
namespace {

static_assert(sizeof(hid_t) == sizeof(Hdf5Handle::Identifier));

/// Chunks of so many rows are compressed by themselves.
constexpr hsize_t kChunkRows = 4096;
constexpr unsigned kDeflate = 4;

/// Before the library's first use: see the class. Quiet: what goes wrong is told by our own errors.
void prepare_library() {
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// What the system said, as the library quotes it: "..., error message = 'No space left on device', ...".
herr_t find_reason(unsigned, const H5E_error2_t* entry, void* found) {
  constexpr std::string_view kBegin = "error message = '";
  const std::string_view text = entry->desc == nullptr ? "" : entry->desc;
  const std::size_t begin = text.find(kBegin);
  if (begin == std::string_view::npos) return 0;
  const std::string_view reason = text.substr(begin + kBegin.size());
  *static_cast<std::string*>(found) = reason.substr(0, reason.find('\''));
  return 1;
}

/// ": <what the system said>" of the last failure; empty where it is not known.
std::string reason_of_failure() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, find_reason, &reason);
  return reason.empty() ? reason : ": " + reason;
}

Hdf5Handle property_of_links() {
  Hdf5Handle properties(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  if (properties.is_open()) H5Pset_create_intermediate_group(properties.get(), 1);
  return properties;
}

}  // namespace

Result<Hdf5File> Hdf5File::create(const std::filesystem::path& path) {
  prepare_library();
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    return fail(ErrorCode::kAlreadyExists,
                fmt::format("'{}': already exists; use a new path", path.string()));
  }
  Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!file.is_open())
    return fail(ErrorCode::kIo, fmt::format("'{}': cannot be created{}", path.string(), reason_of_failure()));
  return Hdf5File(path, std::move(file));
}

Error Hdf5File::error(const std::string& object) const {
  return fail(ErrorCode::kIo,
              fmt::format("'{}': '{}' cannot be written{}", path_.string(), object, reason_of_failure()));
}

Result<void> Hdf5File::make_group(const std::string& path) {
  const Hdf5Handle properties = property_of_links();
  const Hdf5Handle group(H5Gcreate2(file_.get(), path.c_str(), properties.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Gclose);
  if (!group.is_open()) return error(path);
  return {};
}

Result<void> Hdf5File::write_data(const std::string& path, Hdf5Handle::Identifier type, const void* data,
                                  std::span<const std::uint64_t> shape, const std::string& units,
                                  const std::string& description) {
  std::vector<hsize_t> sizes(shape.begin(), shape.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
  const Hdf5Handle links = property_of_links();
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (!space.is_open() || !creation.is_open()) return error(path);
  if (sizes[0] > kChunkRows) {
    std::vector<hsize_t> chunk = sizes;
    chunk[0] = kChunkRows;
    if (H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data()) < 0 ||
        H5Pset_deflate(creation.get(), kDeflate) < 0) {
      return error(path);
    }
  }
  {
    const Hdf5Handle dataset(
        H5Dcreate2(file_.get(), path.c_str(), type, space.get(), links.get(), creation.get(), H5P_DEFAULT),
        H5Dclose);
    if (!dataset.is_open()) return error(path);
    if (H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) return error(path);
  }
  TONUS_TRY(set(path, "units", units));
  return set(path, "description", description);
}

Result<void> Hdf5File::write(const std::string& path, std::span<const double> values, std::size_t columns,
                             const std::string& units, const std::string& description) {
  std::vector<std::uint64_t> shape{values.size()};
  if (columns > 0) shape = {values.size() / columns, columns};
  return write_data(path, H5T_NATIVE_DOUBLE, values.data(), shape, units, description);
}

Result<void> Hdf5File::write(const std::string& path, std::span<const std::int64_t> values,
                             const std::string& units, const std::string& description) {
  const std::uint64_t shape[] = {values.size()};
  return write_data(path, H5T_NATIVE_INT64, values.data(), shape, units, description);
}

Result<void> Hdf5File::write(const std::string& path, std::span<const std::uint8_t> values,
                             const std::string& units, const std::string& description) {
  const std::uint64_t shape[] = {values.size()};
  return write_data(path, H5T_NATIVE_UINT8, values.data(), shape, units, description);
}

Result<void> Hdf5File::set_data(const std::string& path, const std::string& name, Hdf5Handle::Identifier type,
                                const void* data) {
  const Hdf5Handle object(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  if (!object.is_open() || !space.is_open()) return error(path);
  const Hdf5Handle attribute(
      H5Acreate2(object.get(), name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.is_open() || H5Awrite(attribute.get(), type, data) < 0) return error(path + ":" + name);
  return {};
}

Result<void> Hdf5File::set(const std::string& path, const std::string& name, const std::string& text) {
  // Of variable length: readers take it for text, not for bytes.
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  if (!type.is_open() || H5Tset_size(type.get(), H5T_VARIABLE) < 0 ||
      H5Tset_cset(type.get(), H5T_CSET_UTF8) < 0) {
    return error(path + ":" + name);
  }
  const char* characters = text.c_str();
  return set_data(path, name, type.get(), &characters);
}

Result<void> Hdf5File::set(const std::string& path, const std::string& name, double value) {
  return set_data(path, name, H5T_NATIVE_DOUBLE, &value);
}

Result<void> Hdf5File::set(const std::string& path, const std::string& name, std::int64_t value) {
  return set_data(path, name, H5T_NATIVE_INT64, &value);
}

Result<void> Hdf5File::finish() {
  if (H5Fflush(file_.get(), H5F_SCOPE_GLOBAL) < 0) return error("/");
  if (!file_.close()) return error("/");
  const FileDescriptor written(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
  if (!written.is_open() || ::fsync(written.get()) != 0) return file_error(path_, "cannot be written");
  return {};
}

}  // namespace tonus::formats
