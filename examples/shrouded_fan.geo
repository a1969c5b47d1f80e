// Twelve curved blades with a shroud on a disk, in millimetres, as lines. Meshed by
//
//     pip install gmsh && gmsh -1 examples/shrouded_fan.geo -o examples/shrouded_fan.msh
//
// The physical groups are what examples/shrouded_fan.toml names.

blades = 12;
root = 80;
shroud = 260;
tip = 400;
lean = Pi / 24; // how far the tip runs ahead of the root
alpha = 2 * Pi / blades;

centre = 1;
Point(centre) = {0, 0, 0};

For n In {0 : blades - 1}
  angle = n * alpha;
  Point(10 + n) = {root * Cos(angle), root * Sin(angle), 0};
  Point(100 + n) = {shroud * Cos(angle + 0.3 * lean), shroud * Sin(angle + 0.3 * lean), 0};
  Point(200 + n) = {tip * Cos(angle + lean), tip * Sin(angle + lean), 0};
  r = (root + shroud) / 2;
  Point(300 + n) = {r * Cos(angle + 0.06 * lean), r * Sin(angle + 0.06 * lean), 0};
  r = (shroud + tip) / 2;
  Point(400 + n) = {r * Cos(angle + 0.6 * lean), r * Sin(angle + 0.6 * lean), 0};
EndFor

For n In {0 : blades - 1}
  next = (n + 1) % blades;
  Line(10 + n) = {centre, 10 + n};
  Circle(100 + n) = {10 + n, centre, 10 + next};
  BSpline(200 + n) = {10 + n, 300 + n, 100 + n};
  BSpline(300 + n) = {100 + n, 400 + n, 200 + n};
  Circle(400 + n) = {100 + n, centre, 100 + next};
EndFor

// Gmsh lays straight two-node lines along the curves.
Transfinite Curve{10 : 10 + blades - 1} = 2;
Transfinite Curve{100 : 100 + blades - 1} = 3;
Transfinite Curve{200 : 200 + blades - 1} = 6;
Transfinite Curve{300 : 300 + blades - 1} = 5;
Transfinite Curve{400 : 400 + blades - 1} = 5;

Physical Point("hub") = {centre};
Physical Point("blade tips") = {200 : 200 + blades - 1};
Physical Curve("disk") = {10 : 10 + blades - 1, 100 : 100 + blades - 1};
Physical Curve("blades") = {200 : 200 + blades - 1, 300 : 300 + blades - 1};
Physical Curve("shroud") = {400 : 400 + blades - 1};
