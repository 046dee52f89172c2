#include "studio/routes/page_routes.h"

#include <gtest/gtest.h>

#include "core/testing/folder.h"
#include "studio/routes/pages.h"

namespace keypose::studio::page_routes_test {

RouteTable::Handler Says(const std::string& text) {
  return [text](const Question&) { return TextAnswer(text); };
}

std::string Asked(const RouteTable& table, const std::string& method, const std::string& path) {
  const RouteTable::Route* route = table.Find(method, path);
  return route ? route->handler({method, path, {}, ""}).bytes : "nothing";
}

TEST(RouteTable, AnswersByMethodAndPath) {
  RouteTable table;
  table.Get("/api/keys", Says("read"));
  table.Put("/api/keys", Says("kept"));
  EXPECT_EQ(Asked(table, "GET", "/api/keys"), "read");
  EXPECT_EQ(Asked(table, "PUT", "/api/keys"), "kept");
  EXPECT_EQ(Asked(table, "POST", "/api/keys"), "nothing");
  EXPECT_EQ(Asked(table, "GET", "/api/keys/"), "nothing");
}

TEST(RouteTable, AFolderIsAnsweredForAllThatIsBelow) {
  RouteTable table;
  table.GetBelow("/report/", Says("below"));
  EXPECT_EQ(Asked(table, "GET", "/report/a/b.html"), "below");
  EXPECT_EQ(Asked(table, "GET", "/report"), "nothing");
  EXPECT_EQ(Asked(table, "PUT", "/report/a"), "nothing");
}

TEST(RouteTable, AChangeIsOfTheProjectUnlessItIsSaid) {
  RouteTable table;
  table.Get("/a", Says(""));
  table.Post("/a", Says(""));
  table.Put("/a", Says(""), Changes::kQuietly);
  EXPECT_EQ(table.Find("GET", "/a")->changes, Changes::kNothing);
  EXPECT_EQ(table.Find("POST", "/a")->changes, Changes::kProject);
  EXPECT_EQ(table.Find("PUT", "/a")->changes, Changes::kQuietly);
}

class AllOfThem : public ::testing::Test, public TestingFolder {};

TEST_F(AllOfThem, OnlyWhatIsSaidIsQuiet) {
  SharedProject project(folder_);
  const auto pages = AllPages(project);
  RouteTable table;
  for (const auto& page : pages) page->AddTo(table);
  const auto changes = [&](const std::string& method, const std::string& path) {
    return table.Find(method, path)->changes;
  };
  EXPECT_EQ(changes("PUT", "/api/timeline"), Changes::kProject);
  EXPECT_EQ(changes("PUT", "/api/armature/take/use"), Changes::kProject);
  EXPECT_EQ(changes("POST", "/api/shot/quick"), Changes::kNothing);
  // They come by the hundred, or tell of themselves.
  EXPECT_EQ(changes("PUT", "/api/photos"), Changes::kQuietly);
  for (const char* path :
       {"run", "stop", "shoot/start", "shoot/command", "shoot/interrupt", "armature/example",
        "armature/start", "armature/command", "armature/interrupt", "armature/bake",
        "armature/take/open", "armature/take/draft", "armature/take/save"})
    EXPECT_EQ(changes("POST", std::string("/api/") + path), Changes::kQuietly) << path;
}

}  // namespace keypose::studio::page_routes_test
