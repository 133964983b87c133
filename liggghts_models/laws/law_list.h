// SPDX-License-Identifier: GPL-2.0-or-later
//
// Laws that a script chooses by name: what a list of them (laws.h) is asked for.
#ifndef FLOE_LAWS_LAW_LIST_H
#define FLOE_LAWS_LAW_LIST_H

#include <string>

namespace floe {

// A keyword of the pair style that one law alone reads: a number above 0, and its default.
struct LawKeyword {
  const char *name;
  double value;
};
constexpr int law_keywords = 4;  // that a law may have
using LawKeywords = LawKeyword[law_keywords];

template <typename... Laws>
struct LawList {
  static constexpr int count = sizeof...(Laws);
  // The law's place in the list, -1 where none has that name.
  static int number(const std::string &name) {
    int at = 0, found = -1;
    ((name == Laws::name ? void(found = at++) : void(++at)), ...);
    return found;
  }
  // "this or that", of those that are chosen: all, if nothing is said.
  template <typename Choose>
  static std::string names(Choose choose) {
    std::string out;
    each([&](auto law) {
      if (choose(law)) out += (out.empty() ? "" : " or ") + std::string(law.name);
    });
    return out;
  }
  static std::string names() {
    return names([](auto) { return true; });
  }
  // Calls with the law of that place, and returns what that returns.
  template <typename Call>
  static auto with(int number, Call call) {
    return pick<Call, Laws...>(number, call);
  }
  // Calls with each in turn.
  template <typename Call>
  static void each(Call call) {
    (call(Laws{}), ...);
  }

 private:
  template <typename Call, typename First, typename... Rest>
  static auto pick(int number, Call &call) -> decltype(call(First{})) {
    if constexpr (sizeof...(Rest) > 0) {
      if (number > 0) return pick<Call, Rest...>(number - 1, call);
    }
    return call(First{});
  }
};

// The LawList of a macro that names each of its laws: FLOE_LAW_LIST(FLOE_BOND_LAWS).
template <typename, typename... Laws>
struct ListBehind {
  using type = LawList<Laws...>;
};
#define FLOE_LAW_COMMA(Law) , Law
#define FLOE_LAW_LIST(LAWS) ListBehind<void LAWS(FLOE_LAW_COMMA)>::type

}  // namespace floe

#endif
