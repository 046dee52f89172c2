#include "cleanup/ground.h"
