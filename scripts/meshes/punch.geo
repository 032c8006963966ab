// A half-round punch (R = 1) above a block, all quadrilaterals, graded towards the place where they will touch.
//
// Bodies: "punch", the lower half of a disk around (0, 1 + gap), and "block", 4 wide and 1.5 high below y = 0.
// Boundaries: of the punch "round" and "flat", of the block "surface", "left", "right" and "base".
// Made with:  gmsh -2 punch.geo -format msh41 -o punch.msh

gap = 0.01;         // between the lowest point of the punch and the block
R = 1;
core = 0.5;         // radius of the corners of the inner quadrilateral
bottom = 15;        // facets along the middle arc, from 240 to 300 degrees
side = 6;           // facets along each of the two outer arcs
across = 6;         // cells between the arcs and the inner quadrilateral
width = 4;
height = 1.5;

Mesh.ElementOrder = 1;
Mesh.RecombineAll = 1;
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 0;

// the punch: an inner quadrilateral, and a patch along each arc
y0 = R + gap;
c = Cos(Pi / 3);
s = Sin(Pi / 3);
Point(1) = {0, y0, 0};
Point(2) = {-R, y0, 0};
Point(3) = {-R * c, y0 - R * s, 0};
Point(4) = {R * c, y0 - R * s, 0};
Point(5) = {R, y0, 0};
Point(6) = {-core, y0, 0};
Point(7) = {-core * c, y0 - core * s, 0};
Point(8) = {core * c, y0 - core * s, 0};
Point(9) = {core, y0, 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 5};
Line(4) = {6, 7};
Line(5) = {7, 8};
Line(6) = {8, 9};
Line(7) = {6, 2};
Line(8) = {7, 3};
Line(9) = {8, 4};
Line(10) = {9, 5};
Line(11) = {9, 6};
Curve Loop(1) = {7, 1, -8, -4};
Curve Loop(2) = {8, 2, -9, -5};
Curve Loop(3) = {9, 3, -10, -6};
Curve Loop(4) = {4, 5, 6, 11};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Plane Surface(3) = {3};
Plane Surface(4) = {4};
Transfinite Curve{1, 3, 4, 6} = side + 1;
Transfinite Curve{2, 5, 11} = bottom + 1;
Transfinite Curve{7, 8, 9, 10} = across + 1 Using Progression 0.85;
Transfinite Surface{1:4};

// the block: two halves in width, finest at the middle of its surface
Point(11) = {-width / 2, -height, 0};
Point(12) = {0, -height, 0};
Point(13) = {width / 2, -height, 0};
Point(14) = {width / 2, 0, 0};
Point(15) = {0, 0, 0};
Point(16) = {-width / 2, 0, 0};
Line(21) = {11, 12};
Line(22) = {12, 13};
Line(23) = {13, 14};
Line(24) = {14, 15};
Line(25) = {15, 16};
Line(26) = {16, 11};
Line(27) = {12, 15};
Curve Loop(11) = {21, 27, 25, 26};
Curve Loop(12) = {22, 23, 24, -27};
Plane Surface(11) = {11};
Plane Surface(12) = {12};
Transfinite Curve{22, -21, 25, -24} = 16 Using Progression 1.1;
Transfinite Curve{-23, -27, 26} = 9 Using Progression 1.2;
Transfinite Surface{11, 12};

Physical Surface("punch", 1) = {1, 2, 3, 4};
Physical Surface("block", 2) = {11, 12};
Physical Curve("round", 11) = {1, 2, 3};
Physical Curve("flat", 12) = {7, 10, 11};
Physical Curve("surface", 21) = {24, 25};
Physical Curve("left", 22) = {26};
Physical Curve("right", 23) = {23};
Physical Curve("base", 24) = {21, 22};
