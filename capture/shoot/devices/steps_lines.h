// The lines of the turntable protocol `steps:`, which docs/shoot.md describes; both ends of it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace keypose::capture::shoot {

/// CRC-8 with the polynomial 0x07, start 0, not reflected.
std::uint8_t Crc8(std::string_view bytes);

/// A line without its end.
struct StepsLine {
  int sequence = 0;  ///< 0 to 255
  std::string text;  ///< "GO 1600", or "OK at=0 moving=1"
};

/// ">1 HELLO*A3".
/// @param mark  '>' from the host, '<' from the table
std::string FormatStepsLine(char mark, const StepsLine& line);
/// Nothing if the line has another form or a wrong checksum. Bytes before the mark are skipped.
std::optional<StepsLine> ParseStepsLine(char mark, std::string_view line);

/// The numbers of a reply: {"at": 0, "moving": 1} of "OK at=0 moving=1"; without those that are
/// not whole numbers.
std::map<std::string, std::int64_t> StepsValues(std::string_view reply);

}  // namespace keypose::capture::shoot
