#include "studio/routes/serial_ports.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

json SerialPorts() {
  json ports = json::array();
  std::vector<fs::path> named;
  std::error_code error;
  for (const auto& link : fs::directory_iterator("/dev/serial/by-id", error)) {
    ports.push_back({{"path", link.path().string()}, {"name", link.path().filename().string()}});
    named.push_back(fs::weakly_canonical(link.path(), error));
  }
  for (const auto& device : fs::directory_iterator("/dev", error)) {
    const std::string name = device.path().filename().string();
    if (!name.starts_with("ttyUSB") && !name.starts_with("ttyACM")) continue;
    if (std::find(named.begin(), named.end(), device.path()) == named.end())
      ports.push_back({{"path", device.path().string()}, {"name", name}});
  }
  return ports;
}

}  // namespace keypose::studio
