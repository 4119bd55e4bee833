// Counts nested XML elements as parsers do.
#include "saltus/robots/model/xml_nesting.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/app/support.hpp"

namespace saltus {
namespace {

std::string times(int n, const std::string& text) {
  std::string all;
  for (int i = 0; i < n; ++i) all += text;
  return all;
}

constexpr int allowed = robots::deepest_element;

TEST(XmlNesting, CountsOpenElements) {
  EXPECT_FALSE(robots::xml_nesting_error(""));
  EXPECT_FALSE(
      robots::xml_nesting_error("<?xml version='1.0'?><!DOCTYPE r><r><a b='1'/><c></c></r>"));
  EXPECT_FALSE(robots::xml_nesting_error(times(allowed, "<a>") + times(allowed, "</a>")));
  EXPECT_FALSE(robots::xml_nesting_error("<r>" + times(1000, "<a></a><b/>") + "</r>"));
  EXPECT_TRUE(robots::xml_nesting_error(times(allowed + 1, "<a>")));
  EXPECT_TRUE(robots::xml_nesting_error(times(allowed + 1, "<a b='c'>")));
}

// Text that looks like a closing tag but does not close an element.
TEST(XmlNesting, IgnoresNonTags) {
  for (const char* other : {"<![CDATA[</a></a>]]>", "<!-- </a></a> -->", "<!--> </a></a> -->",
                            "<a b='</a></a>'/>", "<a b=\"/>\"></a>"})
    EXPECT_TRUE(robots::xml_nesting_error("<r>" + times(allowed + 1, std::string("<a>") + other)))
        << other;
  EXPECT_TRUE(robots::xml_nesting_error(times(allowed + 1, "<a b='/>'>")));
  // Text that looks like an opening tag.
  for (const char* other :
       {"<![CDATA[<a><a>]]>", "<!-- <a><a> -->", "<a b='<a><a>'/>", "<a b='>'/>"})
    EXPECT_FALSE(robots::xml_nesting_error("<r>" + times(allowed + 1, other))) << other;
}

TEST(XmlNesting, RejectsAmbiguousXml) {
  EXPECT_TRUE(contains(*robots::xml_nesting_error("<r><?a > </r> ?></r>"), "declaration (<?)"));
  EXPECT_TRUE(contains(*robots::xml_nesting_error("<r><!a [ > ]></r>"), "declaration (<!)"));
  for (const char* other : {"<1 '>", "<:a>", "< a>", "<"})
    EXPECT_TRUE(contains(*robots::xml_nesting_error(std::string("<r>") + other), "&lt;")) << other;
}

TEST(XmlNesting, LeavesUnclosedElementsToTheParser) {
  for (const char* text : {"<r", "<r a='", "<!-- ", "<![CDATA[", "<?xml", "</r"})
    EXPECT_FALSE(robots::xml_nesting_error(text)) << text;
}

}  // namespace
}  // namespace saltus
