#include "rig_agent/drivers/library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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

template <std::size_t kSize>
std::string text_in(const char (&text)[kSize]) {
  return {text, ::strnlen(text, kSize)};
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

Result<Library::Tables> Library::open(const std::filesystem::path& file) {
  std::error_code error;
  const auto path = std::filesystem::absolute(file, error);
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(path, error))
    return fail(ErrorCode::kNotFound, fmt::format("driver {}: there is no such file", name));
  Tables tables{Handle(::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)), {}, {}};
  void* const handle = tables.handle.get();
  if (handle == nullptr) return refuse(name, fmt::format("cannot be loaded: {}", ::dlerror()));
  const auto second = reinterpret_cast<decltype(&tonus_driver_v2)>(::dlsym(handle, "tonus_driver_v2"));
  const auto first = reinterpret_cast<decltype(&tonus_driver_v1)>(::dlsym(handle, "tonus_driver_v1"));
  if (second == nullptr && first == nullptr)
    return refuse(name, "is not a driver: it has no function tonus_driver_v1 or tonus_driver_v2");
  const tonus_driver_v2_table* extended = second != nullptr ? second() : nullptr;
  const tonus_driver_v1_table* table = extended != nullptr ? &extended->base
                                       : first != nullptr  ? first()
                                                           : nullptr;
  if (table == nullptr) return refuse(name, "its function returned no table");
  const bool is_second = extended != nullptr;
  const std::uint32_t version = is_second ? TONUS_DRIVER_VERSION_2 : TONUS_DRIVER_VERSION;
  // The first libraries of version 2 knew no auxiliary channels.
  const std::size_t size =
      is_second ? offsetof(tonus_driver_v2_table, count_auxiliary) : sizeof(tonus_driver_v1_table);
  const bool has_size = is_second ? table->size >= size : table->size == size;
  if (table->version != version || !has_size) {
    return refuse(
        name, fmt::format("version: {} with a table of {} bytes is not allowed; expected {} with {} bytes",
                          table->version, table->size, version, size));
  }
  if (!is_complete(*table))
    return refuse(name, "a function of its table is missing; begin_trial alone may be");
  tables.base = *table;
  if (!is_second) return tables;
  if (extended->describe_safety == nullptr || extended->disable == nullptr)
    return refuse(name, "describe_safety or disable is missing from its table");
  std::memcpy(&tables.extra, extended, std::min<std::size_t>(table->size, sizeof tables.extra));
  const auto& extra = tables.extra;
  const int parts = (extra.count_auxiliary != nullptr) + (extra.describe_auxiliary != nullptr) +
                    (extra.read_auxiliary != nullptr);
  if (parts != 0 && parts != 3)
    return refuse(name, "of count_auxiliary, describe_auxiliary and read_auxiliary one is missing");
  return tables;
}

Result<std::unique_ptr<Library>> Library::load(const std::filesystem::path& file,
                                               const std::string& options) {
  TONUS_TRY_ASSIGN(auto tables, open(file));
  const std::string name = file.string();
  ErrorText reason{};
  void* rig = tables.base.create(options.c_str(), reason.data(), reason.size());
  if (rig == nullptr) return refuse(name, text_of(reason));
  return std::unique_ptr<Library>(new Library(std::move(tables), rig, name, options));
}

Result<std::function<int(const char*)>> Library::load_disable(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(auto tables, open(file));
  if (tables.extra.disable == nullptr) return refuse(file.string(), "is of version 1: it has no disable()");
  (void)tables.handle.release();
  return std::function<int(const char*)>(tables.extra.disable);
}

Library::~Library() {
  Library::deactivate();
  table_.destroy(rig_);
}

Result<void> Library::configure(double period) {
  if (is_active_)
    return fail(ErrorCode::kUnavailable,
                fmt::format("driver {}: configure() while active is not allowed; expected an inactive driver",
                            name_));
  is_configured_ = false;
  if (!(std::isfinite(period) && period > 0.0))
    return refuse(name_, fmt::format("period: {} s is not allowed; expected more than 0 s", period));
  ErrorText reason{};
  if (table_.configure(rig_, period, reason.data(), reason.size()) != 0)
    return refuse(name_, text_of(reason));
  tonus_driver_description description{};
  table_.describe(rig_, &description);
  geometry_ = geometry_of(description);
  if (auto valid = validate(geometry_); !valid) return refuse(name_, valid.error().message);
  has_own_clock_ = description.has_own_clock != 0;
  if (extra_.describe_safety != nullptr) {
    extra_.describe_safety(rig_, &safety_);
    if (!(safety_.watchdog_ms >= 0.0 && safety_.watchdog_ms <= 10000.0))
      return refuse(name_,
                    fmt::format("watchdog_ms: {} is not allowed; expected 0 to 10000", safety_.watchdog_ms));
  }
  TONUS_TRY(describe_auxiliary());
  is_configured_ = true;
  return {};
}

Result<void> Library::describe_auxiliary() {
  auxiliary_.clear();
  const std::uint32_t count = extra_.count_auxiliary == nullptr ? 0 : extra_.count_auxiliary(rig_);
  if (count > kMostAuxiliaryChannels)
    return refuse(name_, fmt::format("auxiliary channels: {} are not allowed; expected at most {}", count,
                                     kMostAuxiliaryChannels));
  for (std::uint32_t i = 0; i < count; ++i) {
    tonus_driver_auxiliary d{};
    extra_.describe_auxiliary(rig_, i, &d);
    auxiliary_.push_back({text_in(d.name), text_in(d.type), text_in(d.unit), d.unit_per_value, d.rate_Hz});
  }
  for (const auto& stated : stated_) {
    const auto own = std::find_if(auxiliary_.begin(), auxiliary_.end(),
                                  [&](const auto& channel) { return channel.name == stated.name; });
    if (own == auxiliary_.end())
      return refuse(
          name_,
          fmt::format("auxiliary channel {} is not allowed; expected one that the library has", stated.name));
    if (own->rate != stated.rate)
      return refuse(name_, fmt::format("auxiliary channel {}: rate_Hz: {} is not allowed; expected {}, the "
                                       "library's",
                                       stated.name, stated.rate, own->rate));
    *own = stated;
  }
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

void Library::heartbeat(bool level) noexcept {
  if (is_active_ && extra_.heartbeat != nullptr) extra_.heartbeat(rig_, level ? 1 : 0);
}

bool Library::set_onset(bool is_on) noexcept {
  if (!is_active_ || extra_.set_onset == nullptr) return false;
  extra_.set_onset(rig_, is_on ? 1 : 0);
  return true;
}

void Library::read_auxiliary(std::span<const std::uint32_t> counts, std::span<float> values) noexcept {
  if (is_active_ && !auxiliary_.empty()) extra_.read_auxiliary(rig_, counts.data(), values.data());
}

bool Library::disable() noexcept {
  return extra_.disable != nullptr && extra_.disable(options_.c_str()) == 0;
}

}  // namespace tonus::drivers
