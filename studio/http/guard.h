// Who is let in: only the browser that was given the studio's address, and only on this machine.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace keypose::studio {

/// What the guard looks at, before a request's body is read.
struct RequestHead {
  std::string method;  ///< "GET"
  std::string path;    ///< without the query
  std::string host, origin, cookies;
  std::string fetch_site;  ///< Sec-Fetch-Site, which browsers set and pages cannot
  std::string own_header;  ///< X-Keypose, which pages of other origins cannot send
  std::uint64_t body_bytes = 0;
};

struct Refusal {
  int status = 403;
  std::string words;  ///< for the person
};

/// `bits` random bits from the system as hexadecimal digits.
/// @throws std::runtime_error  the system has none
std::string RandomDigits(int bits);

class Guard {
 public:
  /// @param token    lets one browser in, once
  /// @param session  what that browser's cookie says from then on
  Guard(std::string token, std::string session, int port);

  /// The value of Set-Cookie for a browser with the right token. The token is used up.
  std::optional<std::string> Enter(const std::string& token);
  /// A new token, for one more browser; an older one that was not used lets nobody in any more.
  std::string NewToken();
  /// Whether the request comes from a browser that was let in.
  bool HasEntered(const RequestHead& head) const { return HasCookie(head.cookies); }

  /// Nothing if the request may go on.
  std::optional<Refusal> Judge(const RequestHead& head) const;

 private:
  std::optional<Refusal> JudgePlace(const RequestHead& head) const;
  bool HasCookie(const std::string& cookies) const;

  std::mutex mutex_;
  std::string token_;
  const std::string session_, cookie_;
  const int port_;
};

}  // namespace keypose::studio
