within ;
package Contact "The table of a contact as an external function: contact-patch curve ball.json --format c --name ball -o ball_spring.h"

  function force "Normal force at a depth"
    input Real depth;
    output Real force;
    external "C" force = ball_force(depth)
      annotation (Include = "#include \"ball_spring.h\"", IncludeDirectory = "modelica://Contact");
    annotation (derivative = force_der);
  end force;

  function force_der "Its derivative by time, which solvers ask for"
    input Real depth;
    input Real der_depth;
    output Real der_force = stiffness(depth) * der_depth;
  end force_der;

  function stiffness "dP/dd at a depth"
    input Real depth;
    output Real stiffness;
    external "C" stiffness = ball_stiffness(depth)
      annotation (Include = "#include \"ball_spring.h\"", IncludeDirectory = "modelica://Contact");
  end stiffness;

  model Bounce "A ball bounces on a plate"
    parameter Real m = 0.0327 "kg";
    parameter Real v0 = 0.5 "m/s";
    Real depth(start = 0, fixed = true);
    Real velocity(start = v0, fixed = true);
  equation
    der(depth) = velocity;
    m * der(velocity) = -force(depth);
  end Bounce;
end Contact;
