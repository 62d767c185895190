// Six axes, each with the controller that was exported for it: adaptive-ff export axis1.toml --prefix axis1 --out src
#pragma once

#include "axis.hpp"
#include "axis1.h"
#include "axis2.h"
#include "axis3.h"
#include "axis4.h"
#include "axis5.h"
#include "axis6.h"
#include "friction_compensation.hpp"

namespace friction_compensation
{

FRICTION_COMPENSATION_AXIS(Exported1, axis1, AXIS1)
FRICTION_COMPENSATION_AXIS(Exported2, axis2, AXIS2)
FRICTION_COMPENSATION_AXIS(Exported3, axis3, AXIS3)
FRICTION_COMPENSATION_AXIS(Exported4, axis4, AXIS4)
FRICTION_COMPENSATION_AXIS(Exported5, axis5, AXIS5)
FRICTION_COMPENSATION_AXIS(Exported6, axis6, AXIS6)

using Axis1 = FrictionCompensation<Exported1>;
using Axis2 = FrictionCompensation<Exported2>;
using Axis3 = FrictionCompensation<Exported3>;
using Axis4 = FrictionCompensation<Exported4>;
using Axis5 = FrictionCompensation<Exported5>;
using Axis6 = FrictionCompensation<Exported6>;

}  // namespace friction_compensation
