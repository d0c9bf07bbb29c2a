% Run SDEM (Lyu, Lui, Choi 2024) from a given sphere. Called by balanced_maps.py as
%   octave --path FOLDER sdem.m IN.mat OUT.mat
args = argv();
load(args{1});  % v, f (from 1) and x
began = cputime();
map = SDEM(v, f, face_area(f, v), x, 0.1, 1e-3, 200);
seconds = cputime() - began;
save('-v7', args{2}, 'map', 'seconds');
