#include "rig_agent/watchdog/disable.hpp"

#include "rig_agent/drivers/library.hpp"
#ifdef TONUS_HAS_COMEDI
#include "rig_agent/drivers/comedi.hpp"
#endif

namespace tonus::watchdog {

Result<std::function<bool()>> disable_of(const std::string& driver, const std::string& file,
                                         const std::string& options) {
  if (driver == "library") {
    TONUS_TRY_ASSIGN(const auto disable, drivers::Library::load_disable(file));
    return std::function<bool()>([disable, options] { return disable(options.c_str()) == 0; });
  }
#ifdef TONUS_HAS_COMEDI
  if (driver == "comedi") {
    TONUS_TRY_ASSIGN(const auto config, drivers::load_comedi_config(file));
    return std::function<bool()>([config] { return drivers::Comedi::disable(config); });
  }
#endif
  return fail(ErrorCode::kInvalidArgument,
              "driver: " + driver + " is not allowed; expected one that can be disabled from outside");
}

}  // namespace tonus::watchdog
