#include "studio/http/guard.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace keypose::studio::guard_test {

const std::string kToken = "0123456789abcdef", kSession = "fedcba9876543210";

RequestHead Good(const std::string& method = "GET", const std::string& path = "/api/project") {
  return {method, path, "127.0.0.1:4777", "", "a=b; keypose_4777=" + kSession, "same-origin",
          "1",    0};
}

TEST(Guard, LetsTheOwnPageIn) {
  const Guard guard(kToken, kSession, 4777);
  EXPECT_FALSE(guard.Judge(Good()));
  EXPECT_FALSE(guard.Judge(Good("POST", "/api/run")));
  RequestHead named = Good("PUT", "/api/mask");
  named.host = "localhost:4777";
  named.origin = "http://localhost:4777";
  EXPECT_FALSE(guard.Judge(named));
}

TEST(Guard, ATokenLetsOneBrowserInOnce) {
  Guard guard(kToken, kSession, 4777);
  EXPECT_FALSE(guard.Enter("0123456789abcdee"));
  EXPECT_FALSE(guard.Enter(""));
  const auto cookie = guard.Enter(kToken);
  ASSERT_TRUE(cookie);
  EXPECT_NE(cookie->find("keypose_4777=" + kSession), std::string::npos);
  EXPECT_NE(cookie->find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie->find("SameSite=Strict"), std::string::npos);
  EXPECT_FALSE(guard.Enter(kToken));
}

TEST(Guard, ANewTokenLetsAnotherBrowserInAndReplacesTheOlder) {
  Guard guard(kToken, kSession, 4777);
  const std::string next = guard.NewToken();
  EXPECT_EQ(next.size(), 32U);
  EXPECT_FALSE(guard.Enter(kToken)) << "one address at a time";
  EXPECT_TRUE(guard.Enter(next));
  EXPECT_FALSE(guard.Enter(next));
  EXPECT_TRUE(guard.HasEntered(Good()));
  EXPECT_FALSE(guard.HasEntered({}));
}

TEST(Guard, OtherHostNamesAreRefused) {
  const Guard guard(kToken, kSession, 4777);
  for (const char* host : {"evil.example:4777", "127.0.0.1", "127.0.0.1:4778", "", "localhost",
                           "127.0.0.1:4777.evil.example", "[::1]:4777", "0.0.0.0:4777"}) {
    RequestHead head = Good();
    head.host = host;
    ASSERT_TRUE(guard.Judge(head)) << host;
    EXPECT_EQ(guard.Judge(head)->status, 403);
  }
}

TEST(Guard, OtherOriginsAreRefused) {
  const Guard guard(kToken, kSession, 4777);
  for (const char* origin : {"http://evil.example", "null", "https://127.0.0.1:4777",
                             "http://127.0.0.1:8000", "http://localhost:4777"}) {
    RequestHead head = Good("POST", "/api/run");
    head.origin = origin;
    ASSERT_TRUE(guard.Judge(head)) << origin;
    EXPECT_EQ(guard.Judge(head)->status, 403);
  }
  for (const char* site : {"cross-site", "same-site"}) {
    RequestHead head = Good();
    head.fetch_site = site;
    ASSERT_TRUE(guard.Judge(head)) << site;
  }
}

TEST(Guard, RequestsWithoutTheCookieAreRefused) {
  const Guard guard(kToken, kSession, 4777);
  const std::vector<std::string> wrong = {"",
                                          "keypose_4777=",
                                          "keypose_4778=" + kSession,
                                          "keypose_4777=" + kSession + "0",
                                          "xkeypose_4777=" + kSession,
                                          "keypose_4777=" + kToken};
  for (const std::string& cookies : wrong) {
    RequestHead head = Good();
    head.cookies = cookies;
    ASSERT_TRUE(guard.Judge(head)) << cookies;
    EXPECT_EQ(guard.Judge(head)->status, 403);
  }
}

TEST(Guard, ChangesNeedTheHeaderThatOtherPagesCannotSend) {
  const Guard guard(kToken, kSession, 4777);
  RequestHead head = Good("POST", "/api/run");
  head.own_header = "";
  ASSERT_TRUE(guard.Judge(head));
  EXPECT_EQ(guard.Judge(head)->status, 403);
  EXPECT_EQ(guard.Judge(Good("DELETE", "/api/run"))->status, 405);
  EXPECT_EQ(guard.Judge(Good("TRACE", "/"))->status, 405);
}

TEST(Guard, BodiesThatAreTooLargeAreRefusedBeforeTheyAreRead) {
  const Guard guard(kToken, kSession, 4777);
  RequestHead head = Good("POST", "/api/run");
  head.body_bytes = 33u << 20;
  ASSERT_TRUE(guard.Judge(head));
  EXPECT_EQ(guard.Judge(head)->status, 413);
  head.path = "/api/mask";
  EXPECT_FALSE(guard.Judge(head));
}

TEST(Guard, RandomDigitsAreAsManyAsAskedAndNeverTheSame) {
  EXPECT_EQ(RandomDigits(128).size(), 32U);
  EXPECT_NE(RandomDigits(128), RandomDigits(128));
}

}  // namespace keypose::studio::guard_test
