"""The speed controllers: the paper's pedals coupled with the steering, and a PID on the speed."""
