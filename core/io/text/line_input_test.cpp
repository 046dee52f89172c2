#include "core/io/text/line_input.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <string_view>

namespace keypose::line_input_test {

class Pipe {
 public:
  Pipe() { EXPECT_EQ(::pipe(ends_), 0); }
  ~Pipe() {
    ::close(ends_[0]);
    Close();
  }
  int out() const { return ends_[0]; }
  void Put(std::string_view bytes) {
    EXPECT_EQ(::write(ends_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void Close() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  int ends_[2] = {-1, -1};
};

TEST(LineInput, LinesComeWithoutTheirEndAndALastOneNeedsNone) {
  Pipe pipe;
  LineInput input(pipe.out());
  pipe.Put("one\n\ntwo\nthr");
  EXPECT_EQ(input.Next(1), "one");
  EXPECT_EQ(input.Next(1), "");
  EXPECT_EQ(input.Next(1), "two");
  EXPECT_FALSE(input.Next(0.01));
  pipe.Put("ee");
  pipe.Close();
  std::optional<std::string> last;
  for (int i = 0; i < 100 && !last; ++i) last = input.Next(0.05);
  EXPECT_EQ(last, "three");
  EXPECT_TRUE(input.over());
  EXPECT_FALSE(input.Next(0));
}

TEST(LineInput, ALineBeyondTheLimitIsDroppedAndTheNextOneComes) {
  Pipe pipe;
  LineInput input(pipe.out());
  for (int i = 0; i < 40; ++i) {  // 80 KB, more than a pipe holds at once
    pipe.Put(std::string(2000, 'x'));
    EXPECT_FALSE(input.Next(0.01));
  }
  pipe.Put("end of it\nnext\n");
  std::optional<std::string> next;
  for (int i = 0; i < 100 && !next; ++i) next = input.Next(0.05);
  EXPECT_EQ(next, "next");
}

}  // namespace keypose::line_input_test
