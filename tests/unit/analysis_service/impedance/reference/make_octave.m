% Writes octave.txt: the state-variable filter by the matrix exponential and the fit by Octave's \, from record.txt.
1;
function s = filtered(u, A, b, h)
  % Exact for a first-order hold: exp of [A b 0; 0 0 1/h; 0 0 0] h; a zero sample stands before the first.
  E = expm([A*h, b*h, [0;0]; 0 0 0 1; 0 0 0 0]);
  Phi = E(1:2,1:2); G1 = E(1:2,4); G0 = E(1:2,3) - G1;
  s = zeros(numel(u), 2); state = [0;0]; before = 0;
  for k = 1:numel(u)
    state = Phi*state + G0*before + G1*u(k);
    s(k,:) = state'; before = u(k);
  end
end
record = load('record.txt');
h = 0.005; rest = 20; window = 100; wn = 2*pi*2.3; zeta = 0.1;
A = [0 1; -wn^2 -2*zeta*wn]; b = [0; wn^2];
phi = []; force = [];
for trial = 1:4
  rows = record(record(:,1) == trial, 2:5);
  rows = rows - mean(rows(1:rest,:));
  a = []; v = []; y = []; f = [];
  for axis = 1:2
    s = filtered(rows(:,axis), A, b, h);
    y(:,axis) = s(:,1); v(:,axis) = s(:,2);
    a(:,axis) = wn^2*(rows(:,axis) - s(:,1)) - 2*zeta*wn*s(:,2);
    f(:,axis) = filtered(rows(:,2+axis), A, b, h)(:,1);
  end
  if trial == 1, first = [a v y f]; end
  fitted = rest+1:rest+window;
  phi = [phi; a(fitted,:) v(fitted,:) y(fitted,:) ones(window,1)];
  force = [force; f(fitted,:)];
end
theta = phi \ force;
out = fopen('octave.txt', 'w');
function write(out, name, values)
  fprintf(out, '%s %d %d\n', name, rows(values), columns(values));
  for i = 1:rows(values), fprintf(out, '%.17g ', values(i,:)); fprintf(out, '\n'); end
end
write(out, 'state_variable', first);
write(out, 'state_variable_theta', theta);
write(out, 'state_variable_sigma', sqrt(mean((force - phi*theta).^2)));
fclose(out);
