#pragma once

namespace tellurion::io {

/// The calling thread gets less of the cores than the program's others from here on, where there is not enough for all:
/// about a third of what one of them gets, and none of them is interrupted when it wakes. Nothing happens on systems
/// where threads of a program cannot differ.
void stepBack();

}  // namespace tellurion::io
