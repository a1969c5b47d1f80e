% Points of nlvib_example_03.csv: NLvib 1.3 (M. Krack, J. Gross, Harmonic Balance for Nonlinear
% Vibration Problems, Springer 2019), example 03, a two-degree-of-freedom oscillator with a
% unilateral spring, in GNU Octave 7.3 with H = 41 and N = 2^10. Its branch is followed by arclength
% from a frequency without contact, and solved by Newton's method at each listed frequency. Columns:
% frequency, amplitudes of the fundamental harmonic of the second and of the first mass, then mean
% and 20 cosines and sines of the first mass. Three motions that hardly touch the spring, beside which
% there are motions without contact, are left out.
addpath('NLvib/SRC');
s.M = eye(2); s.K = [1 -1; -1 2]; s.D = .03*s.K; s.Fex1 = [0;.1];
s.nonlinear_elements = {struct('type','unilateralSpring','stiffness',1e2,'gap',1,...
    'force_direction',[1;0],'ishysteretic',0,'islocal',1)};
n = 2; H = 41; N = 2^10; Om = .66; ds = .01;
X = zeros((2*H+1)*n+1,1); X(end) = Om;
Q1 = (-Om^2*s.M + 1i*Om*s.D + s.K)\s.Fex1;
X(n+(1:2*n)) = [real(Q1);-imag(Q1)];
[R,dR] = HB_residual(X,s,H,N,'frf');
z = [zeros(length(X)-1,1);-1];
while X(end) > .5
  t = [dR;z']\[zeros(length(X)-1,1);1]; t = t/norm(t); if t'*z < 0, t = -t; end
  Xn = X + ds*t; ok = 0;
  for it = 1:12
    [R,dRn] = HB_residual(Xn,s,H,N,'frf');
    if norm(R) < 1e-10, ok = 1; break; end
    Xn = Xn - [dRn;t']\[R;t'*(Xn-X)-ds];
  end
  if ~ok || norm(Xn-X) > 2*ds, ds = ds/2; continue; end
  for o = .5:.02:.8
    if (X(end)-o)*(Xn(end)-o) < 0
      Y = X(1:end-1) + (o-X(end))/(Xn(end)-X(end))*(Xn(1:end-1)-X(1:end-1));
      for it = 1:40
        [R,dRo] = HB_residual([Y;o],s,H,N,'frf');
        if norm(R) < 1e-11
          c = [Y(1); reshape([Y(n+1+2*n*(0:19)')'; Y(2*n+1+2*n*(0:19)')'],[],1)];
          printf('%.2f,%.8f,%.8f',o,norm(Y([n+2 2*n+2])),norm(Y([n+1 2*n+1])));
          printf(',%.7g',c); printf('\n'); break;
        end
        Y = Y - dRo(:,1:end-1)\R;
      end
    end
  end
  z = t; X = Xn; dR = dRn; if it <= 4, ds = min(ds*1.5,.03); end
end
