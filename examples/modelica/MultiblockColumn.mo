within ;
package MultiblockColumn "A column of rigid blocks, as an FMU for co-simulation, on bodies of Modelica"
  extends Modelica.Icons.Package;

  model BaseFlange "The column as a body with a mass that changes: force on the flanges R0 - m a"
    parameter Modelica.Units.SI.Time h(min = 1e-6) = 1e-3 "Communication step of the FMU";
    input Modelica.Units.SI.Force R0x;
    input Modelica.Units.SI.Force R0z;
    input Modelica.Units.SI.Torque R0m;
    input Modelica.Units.SI.Mass mxx;
    input Modelica.Units.SI.Mass mxz;
    input Real mxt(unit = "kg.m");
    input Modelica.Units.SI.Mass mzz;
    input Real mzt(unit = "kg.m");
    input Modelica.Units.SI.Inertia mtt;
    output Modelica.Units.SI.Acceleration ax "To base.ax: at the communication point";
    output Modelica.Units.SI.Acceleration az "To base.az";
    output Modelica.Units.SI.Jerk jx "To base.jx: slope within the next step, the line since the step before";
    output Modelica.Units.SI.Jerk jz "To base.jz";
    output Modelica.Units.SI.Angle theta "To base.theta, clockwise";
    output Modelica.Units.SI.AngularVelocity omega "To base.omega";
    output Modelica.Units.SI.AngularAcceleration alpha "To base.alpha";
    Modelica.Mechanics.Translational.Interfaces.Flange_a x "Horizontal, positive to +x";
    Modelica.Mechanics.Translational.Interfaces.Flange_a z "Vertical, positive up";
    Modelica.Mechanics.Rotational.Interfaces.Flange_a turn "Clockwise, about the centre of the base joint";
  protected
    Modelica.Units.SI.Velocity vx;
    Modelica.Units.SI.Velocity vz;
    Modelica.Units.SI.AngularVelocity w;
    Modelica.Units.SI.Acceleration a_x;
    Modelica.Units.SI.Acceleration a_z;
    Modelica.Units.SI.AngularAcceleration a_t;
  equation
    vx = der(x.s);
    vz = der(z.s);
    w = der(turn.phi);
    a_x = der(vx);
    a_z = der(vz);
    a_t = der(w);
    // the force into the flange is that of the body on the column: the opposite of the reaction
    x.f = -(R0x - mxx * a_x - mxz * a_z - mxt * a_t);
    z.f = -(R0z - mxz * a_x - mzz * a_z - mzt * a_t);
    turn.tau = -(R0m - mxt * a_x - mzt * a_z - mtt * a_t);
    when sample(0, h) then
      ax = a_x;
      az = a_z;
      jx = if time > 0.5 * h then (ax - pre(ax)) / h else 0;
      jz = if time > 0.5 * h then (az - pre(az)) / h else 0;
      theta = turn.phi;
      omega = w;
      alpha = a_t;
    end when;
  end BaseFlange;

  model Slab "A slab on a linear isolator under the column, the ground acceleration given"
    parameter Modelica.Units.SI.Mass mass = 40e3;
    parameter Modelica.Units.SI.TranslationalSpringConstant stiffness = 1.2e6;
    parameter Modelica.Units.SI.TranslationalDampingConstant damping = 7.6e4;
    input Modelica.Units.SI.Acceleration ground_ax;
    // of the FMU, for the base
    input Modelica.Units.SI.Force R0x;
    input Modelica.Units.SI.Force R0z;
    input Modelica.Units.SI.Torque R0m;
    input Modelica.Units.SI.Mass mxx;
    input Modelica.Units.SI.Mass mxz;
    input Real mxt(unit = "kg.m");
    input Modelica.Units.SI.Mass mzz;
    input Real mzt(unit = "kg.m");
    input Modelica.Units.SI.Inertia mtt;
    BaseFlange base(
      R0x = R0x, R0z = R0z, R0m = R0m, mxx = mxx, mxz = mxz, mxt = mxt, mzz = mzz, mzt = mzt, mtt = mtt);
    Modelica.Mechanics.Translational.Components.Mass slab(m = mass, s(start = 0, fixed = true), v(start = 0, fixed = true));
    Modelica.Mechanics.Translational.Components.SpringDamper isolator(c = stiffness, d = damping);
    Modelica.Mechanics.Translational.Sources.Accelerate ground(s(start = 0, fixed = true), v(start = 0, fixed = true));
    Modelica.Mechanics.Translational.Components.Fixed level;
    Modelica.Mechanics.Rotational.Components.Fixed upright;
  equation
    ground.a_ref = ground_ax;
    connect(ground.flange, isolator.flange_a);
    connect(isolator.flange_b, slab.flange_a);
    connect(slab.flange_b, base.x);
    connect(level.flange, base.z);
    connect(upright.flange, base.turn);
  end Slab;

  model Example "The slab, and the variables of column.fmu that belong to it"
    extends Modelica.Icons.Example;
    // With the FMU imported as `column`, its variables instead of constants: R0x = column.base_R0x, and so on;
    // and equations for its inputs: column.base_ax = slab.base.ax;  column.base_jx = slab.base.jx;  and so on
    parameter Modelica.Units.SI.Force R0x = 0;
    parameter Modelica.Units.SI.Mass mxx = 8.2e3 "Of Phocas at rest";
    Slab slab(
      ground_ax = 0.98 * sin(2 * Modelica.Constants.pi * time),
      R0x = R0x, R0z = 0, R0m = 0, mxx = mxx, mxz = 0, mxt = 0, mzz = 0, mzt = 0, mtt = 0);
    annotation(experiment(StopTime = 10, Interval = 1e-3));
  end Example;

  annotation(uses(Modelica(version = "4.0.0")));
end MultiblockColumn;
