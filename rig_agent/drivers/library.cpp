#include "rig_agent/drivers/library.hpp"

#include <array>
#include <cmath>
#include <dlfcn.h>
#include <spdlog/fmt/fmt.h>

namespace tonus::drivers {
namespace {

using ErrorText = std::array<char, 512>;

Error refuse(const std::string& name, const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, fmt::format("driver {}: {}", name, what));
}

std::string text_of(ErrorText& error) {
  error.back() = '\0';
  return error.front() == '\0' ? "it does not say why" : error.data();
}

DriverStatus status_of(int result) noexcept {
  switch (result) {
    case TONUS_DRIVER_OK:
      return DriverStatus::kOk;
    case TONUS_DRIVER_DISCONNECTED:
      return DriverStatus::kDisconnected;
    default:
      return DriverStatus::kFailed;
  }
}

bool is_complete(const tonus_driver_v1_table& t) {
  return t.create && t.destroy && t.configure && t.describe && t.activate && t.deactivate && t.read &&
         t.write;
}

RigGeometry geometry_of(const tonus_driver_description& d) {
  RigGeometry rig;
  rig.kind = RigKind::kTwoLink;
  rig.links = {d.link_lengths_m[0], d.link_lengths_m[1]};
  for (std::size_t i = 0; i < 2; ++i) {
    rig.counts_per_unit[i] = d.encoder_counts_per_rad[i];
    rig.encoder_zero[i] = d.encoder_zero_count[i];
    rig.encoder_sign[i] = d.encoder_sign[i];
  }
  const auto& c = d.force_calibration_N_per_V;
  rig.force_calibration << c[0], c[1], c[2], c[3];
  rig.force_offset_V = {d.force_offset_V[0], d.force_offset_V[1]};
  rig.force_sensor_angle = d.force_sensor_angle_rad;
  rig.force_saturation_V = d.force_saturation_V;
  rig.handle_mass = d.handle_mass_kg;
  return rig;
}

}  // namespace

void Library::Close::operator()(void* handle) const noexcept { ::dlclose(handle); }

Result<std::unique_ptr<Library>> Library::load(const std::filesystem::path& file,
                                               const std::string& options) {
  std::error_code error;
  const auto path = std::filesystem::absolute(file, error);
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(path, error))
    return fail(ErrorCode::kNotFound, fmt::format("driver {}: there is no such file", name));
  Handle handle(::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL));
  if (!handle) return refuse(name, fmt::format("cannot be loaded: {}", ::dlerror()));
  const auto entry = reinterpret_cast<decltype(&tonus_driver_v1)>(::dlsym(handle.get(), "tonus_driver_v1"));
  if (entry == nullptr) return refuse(name, "is not a driver: it has no function tonus_driver_v1");
  const tonus_driver_v1_table* table = entry();
  if (table == nullptr) return refuse(name, "tonus_driver_v1() returned no table");
  if (table->version != TONUS_DRIVER_VERSION || table->size != sizeof(tonus_driver_v1_table)) {
    return refuse(
        name, fmt::format("version is {} with a table of {} bytes, allowed is {} with {} bytes",
                          table->version, table->size, TONUS_DRIVER_VERSION, sizeof(tonus_driver_v1_table)));
  }
  if (!is_complete(*table))
    return refuse(name, "a function of its table is missing; begin_trial alone may be");
  ErrorText reason{};
  void* rig = table->create(options.c_str(), reason.data(), reason.size());
  if (rig == nullptr) return refuse(name, text_of(reason));
  return std::unique_ptr<Library>(new Library(std::move(handle), *table, rig, name));
}

Library::~Library() {
  Library::deactivate();
  table_.destroy(rig_);
}

Result<void> Library::configure(double period) {
  if (is_active_)
    return fail(ErrorCode::kUnavailable,
                fmt::format("driver {}: configure() while active, allowed is inactive", name_));
  is_configured_ = false;
  if (!(std::isfinite(period) && period > 0.0))
    return refuse(name_, fmt::format("period is {} s, allowed is more than 0 s", period));
  ErrorText reason{};
  if (table_.configure(rig_, period, reason.data(), reason.size()) != 0)
    return refuse(name_, text_of(reason));
  tonus_driver_description description{};
  table_.describe(rig_, &description);
  geometry_ = geometry_of(description);
  if (auto valid = validate(geometry_); !valid) return refuse(name_, valid.error().message);
  has_own_clock_ = description.has_own_clock != 0;
  is_configured_ = true;
  return {};
}

Result<void> Library::activate() {
  if (!is_configured_)
    return fail(ErrorCode::kUnavailable, fmt::format("driver {}: activate() before configure()", name_));
  if (is_active_) return {};
  ErrorText reason{};
  if (table_.activate(rig_, reason.data(), reason.size()) != 0)
    return fail(ErrorCode::kUnavailable, fmt::format("driver {}: {}", name_, text_of(reason)));
  is_active_ = true;
  return {};
}

void Library::deactivate() noexcept {
  table_.deactivate(rig_);
  is_active_ = false;
}

DriverStatus Library::read(Reading& reading) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  tonus_driver_reading raw{};
  const DriverStatus status = status_of(table_.read(rig_, &raw));
  if (status != DriverStatus::kOk) return status;
  if (has_stamp_ && raw.acquisition_ns <= last_ns_) return DriverStatus::kFailed;
  has_stamp_ = true;
  last_ns_ = raw.acquisition_ns;
  reading = Reading{};
  reading.raw.acquisition_ns = raw.acquisition_ns;
  for (std::size_t i = 0; i < 2; ++i) {
    reading.raw.encoder_count[i] = raw.encoder_count[i];
    reading.raw.force_V[i] = raw.force_V[i];
  }
  reading.is_emergency_stop_pressed = raw.is_emergency_stop_pressed != 0;
  return DriverStatus::kOk;
}

DriverStatus Library::write(const Eigen::Vector2d& torque) noexcept {
  if (!is_active_) return DriverStatus::kFailed;
  const bool is_finite = torque.allFinite();
  const double given[2] = {is_finite ? torque[0] : 0.0, is_finite ? torque[1] : 0.0};
  const DriverStatus status = status_of(table_.write(rig_, given));
  return is_finite ? status : DriverStatus::kFailed;
}

void Library::begin_trial(const TrialNotice& notice) noexcept {
  if (!is_active_ || table_.begin_trial == nullptr) return;
  const tonus_driver_trial trial{{notice.shoulder.origin.x(), notice.shoulder.origin.y()},
                                 notice.shoulder.angle,
                                 {notice.posture.x(), notice.posture.y()}};
  table_.begin_trial(rig_, &trial);
}

}  // namespace tonus::drivers
