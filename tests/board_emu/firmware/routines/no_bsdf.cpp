// A shared object, but none for the board.
extern "C" int gicube_something_else(void) { return 0; }
