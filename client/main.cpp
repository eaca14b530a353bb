#include "client/command_line.hpp"

int main(int argc, char** argv) { return tessera::client::run(argc, argv); }
