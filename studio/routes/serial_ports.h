// Serial ports of this machine, for turntables and armatures.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace keypose::studio {

/// [{"path", "name"}, ...]: by the name that tells what is plugged in, if the system gives one.
nlohmann::json SerialPorts();

}  // namespace keypose::studio
