#include "scene/viewer_memory.h"

#include <gtest/gtest.h>

namespace tellurion::scene {
namespace {

TEST(ViewerMemory, comesBack) {
  for (int bits = 0; bits < 32; ++bits) {
    ViewerMemory memory{.layers = (bits & 1) != 0,
                        .settings = (bits & 2) != 0,
                        .statistics = (bits & 4) != 0,
                        .hasHint = (bits & 8) != 0};
    if ((bits & 16) != 0) memory.window = ViewerMemory::Size{.width = 100 + 999 * bits, .height = 65536 - bits};
    const auto back = parseViewerMemory(formatViewerMemory(memory), "viewer.toml");
    ASSERT_TRUE(back) << io::describe(back.error());
    EXPECT_EQ(*back, memory);
  }
  EXPECT_EQ(parseViewerMemory("", "viewer.toml").value(), ViewerMemory());
}

TEST(ViewerMemory, whatCannotBeUnderstoodIsToldWithItsPlace) {
  for (const char* wrong :
       {"window = [0, 5]", "window = [1e9, 800]", "window = 3", "window = [1280]", "panels = \"layers\"",
        "panels = [\"doors\"]", "panels = [3]", "hint = 1", "colour = \"red\"", "= ="}) {
    const auto read = parseViewerMemory(wrong, "viewer.toml");
    ASSERT_FALSE(read) << wrong;
    EXPECT_EQ(io::describe(read.error()).rfind("viewer.toml", 0), 0u) << io::describe(read.error());
  }
}

}  // namespace
}  // namespace tellurion::scene
